// Relaxes in a thread of its own, so that nothing has to wait for it: a cycle of a large volume
// takes seconds, and giving its memory back takes its time too.
//
// The simulation thread starts it from a state, takes what it has reached, and gives it up when a
// person wants something else. Giving up raises a flag that ends the loop in flight within an index
// of it (a guest of the pool, core/parallel) and forgets: nothing of what was given up can be taken
// any more. Its memory is freed here, before the next start.
//
// Doing this between the wishes of the simulation thread is the road not taken: a drag would wait
// for what has no loop to end, such as the coarsest level of multigrid and gigabytes to unmap.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "core/result.h"
#include "deform/deformer.h"

namespace maille {

class Relaxer {
 public:
  struct Reached {
    Lattice lattice;
    bool finished = false;
    std::optional<Lattice> kept = std::nullopt;  // once material has flown
  };
  struct Status {
    bool at_work = false;         // until what it has come to is taken
    RelaxationProgress progress;  // of the last cycle since start(); none yet: all 0
  };

  // reached: called by the relaxing thread when there is something to take. Both outlive this.
  Relaxer(WorkerPool& pool, std::function<void()> reached);
  ~Relaxer();
  Relaxer(const Relaxer&) = delete;
  Relaxer& operator=(const Relaxer&) = delete;

  // Gives up what was on.
  void start(RelaxationStart from, const RelaxationOptions& options);
  void give_up();           // returns at once
  void pause(bool paused);  // from the end of a cycle on
  // Whether the next cycle should leave a state to take, at most one in so many seconds: rounding
  // it takes as long as a part of a cycle. What has finished can be taken anyway.
  void want_state(bool wanted);

  // Once each. Errors: out_of_memory and what Relaxation throws; it has ended then.
  std::optional<Result<Reached>> take();
  Status status() const;

 private:
  struct Job {
    RelaxationStart from;
    RelaxationOptions options;
    std::atomic<bool> given_up{false};
  };
  void run();
  void relax(Job& job);
  void work(Job& job);
  bool may_go_on(const Job& job);  // waits while paused; false: given up
  bool state_is_wanted() const;
  void tell(const Job& job, const RelaxationProgress& progress);
  void leave(const Job& job, Result<Reached> what);

  WorkerPool& pool_;
  std::function<void()> reached_;

  mutable std::mutex mutex_;  // what follows
  std::condition_variable called_;
  std::shared_ptr<Job> job_;   // the last one started, unless given up; null once it has ended
  std::shared_ptr<Job> next_;  // not begun yet
  std::optional<Result<Reached>> reached_state_;
  double left_seconds_ = 0.0;  // when the last state was left
  bool wanted_ = true;
  bool paused_ = false;
  bool stopping_ = false;
  Status status_;

  std::jthread thread_;
};

}  // namespace maille
