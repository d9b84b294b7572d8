// The thread that owns the lattice while a window is open.
//
// Wishes go down: drag targets through a latest-wins mailbox, everything else in order. States come
// up: each a ViewUpdate of one whole step, merged with those nobody has taken yet. No lock is held
// across a step of the work.
//
// A drag is answered at once; while nothing else is asked, relaxation goes on in a thread of its
// own (relaxer.h) from what is shown, the grabbed and pinned elements held, until it has converged.
// What changes the lattice otherwise gives it up where it is and starts from what was shown last.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "app/document.h"
#include "app/relaxer.h"

namespace maille {

struct SimulationStatus {
  std::int64_t elements_moved = 0;  // by the last answered drag
  double drag_ms = 0.0;             // that it took
  bool clamped = false;             // an anchor held the drag back
  bool relaxing = false;
  bool paused = false;
  // Of the relaxation that is on, or the last one until something is changed. Estimated distances
  // to equilibrium, the largest and RMS: infinite where there is none yet.
  bool converged = false;
  bool no_nearer = false;
  double residual_voxels = 0.0;
  double residual_rms_voxels = 0.0;
  std::int64_t iterations = 0;
  std::int64_t free_elements = 0;    // 0: it is being set up
  bool region_limited = false;       // by memory
  std::int64_t volume_elements = 0;  // all there are
  int pins = 0;
  std::int64_t undo_steps_dropped = 0;  // to hold --undo-memory
  std::string refused;                  // why the last wish could not be done; empty: it could
  bool operator==(const SimulationStatus&) const = default;
};

class Simulation {
 public:
  // document: touched by the simulation thread alone until this is destroyed. wake: called on that
  // thread whenever there is something to take, and when a wish is done.
  Simulation(Document& document, std::function<void()> wake);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  void grab(VoxelIndex element, double radius_voxels);
  void drag_to(glm::dvec3 by_voxels);  // total since grab()
  void let_go();                       // the handle stays pinned; without a drag nothing happened
  void cancel();
  void release_pins();
  void undo();
  void redo();
  void pause_or_resume_relaxation();
  void set_materials(MaterialTable table);  // acts from the next step on

  std::optional<ViewUpdate> take_view();
  SimulationStatus status() const;

 private:
  using Wish = std::function<Result<void>()>;
  void ask(Wish wish);
  void run();
  void fulfil(const Wish& wish);
  void give_up(const std::string& reason);
  Result<void> drag_now(glm::dvec3 by_voxels);
  void changed_at_once();  // the lattice jumped: show it, and relax from there
  void start_relaxing();
  void start_now();
  void adopt(Result<Relaxer::Reached> reached);
  void publish();
  template <class F>
  void update_status(F&& change);

  Document& document_;
  std::function<void()> wake_;
  const std::int64_t volume_elements_;
  // The simulation thread's, as is the document.
  double tolerance_voxels_;
  bool wants_to_relax_ = false;  // as soon as nothing else is asked
  bool unpublished_ = false;
  bool dragged_ = false;  // since grab()

  mutable std::mutex mutex_;  // what follows
  std::condition_variable asked_;
  std::deque<Wish> wishes_;
  std::optional<glm::dvec3> drag_target_;  // after all wishes
  std::optional<ViewUpdate> view_;
  SimulationStatus status_;
  bool reached_ = false;  // relaxer_ has something to take
  bool stopping_ = false;

  Relaxer relaxer_;
  std::jthread thread_;
};

}  // namespace maille
