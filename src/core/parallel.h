// A pool of workers for loops over bricks and rows.
//
// Promise: for_each(n, f) calls f(index, worker) once for each index in 0..n-1 and returns when all
// are done; the calling thread works too. Indices are handed out one at a time from a counter, so a
// worker that loses its core delays one item, not its share of the loop. Which worker takes which
// index is not determined: results must not depend on it.
//
// A long piece of work that may have to make way runs on a guest: the same workers, under a flag
// that ends its loops. Neither a flag of the pool itself (loops of others go on) nor one that every
// loop would have to be told of.
//
// TBB is the road not taken: without an instrumented build of it the thread sanitizer reports races
// that are none.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace maille {

// A guest's loop was given up: some of its indices were never handed out.
class Interrupted : public std::exception {
 public:
  const char* what() const noexcept override { return "interrupted"; }
};

class WorkerPool {
 public:
  // threads >= 1 counts the calling thread; 0 asks for one a hardware thread.
  explicit WorkerPool(int threads = 0);
  // A guest: host's workers, but once give_up is set for_each() throws Interrupted, from a loop
  // that is on as soon as each worker is done with the index it has. Both must outlive the guest.
  WorkerPool(WorkerPool& host, const std::atomic<bool>& give_up)
      : host_(&host.host()), give_up_(&give_up) {}
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int thread_count() const {
    return static_cast<int>(host_ ? host_->threads_.size() : threads_.size()) + 1;
  }

  // worker is in 0 .. thread_count()-1 and names scratch memory that no other call uses meanwhile.
  // One loop at a time: calls from several threads wait for one another and go first come, first
  // served, or one that loops without a pause would keep the others out. f must not call for_each
  // of the same pool. What f throws (out of memory) ends the loop early and is thrown here.
  void for_each(std::int64_t count, const std::function<void(std::int64_t index, int worker)>& f) {
    host().loop(count, f, give_up_);
  }

 private:
  WorkerPool& host() { return host_ ? *host_ : *this; }
  void loop(std::int64_t count, const std::function<void(std::int64_t, int)>& f,
            const std::atomic<bool>* give_up);
  void work(int worker);
  void take_items(int worker);

  WorkerPool* host_ = nullptr;  // of a guest, which has nothing of what follows but give_up_
  const std::atomic<bool>* give_up_ = nullptr;

  std::vector<std::jthread> threads_;
  std::mutex mutex_;  // of all that follows
  std::condition_variable turn_over_;
  std::uint64_t turns_given_ = 0;  // to calls of for_each
  std::uint64_t turn_ = 0;         // whose loop it is
  std::condition_variable wake_;
  std::condition_variable done_;
  const std::function<void(std::int64_t, int)>* body_ = nullptr;
  const std::atomic<bool>* body_gives_up_ = nullptr;
  std::exception_ptr thrown_;  // the first, by a body
  std::int64_t count_ = 0;
  std::atomic<std::int64_t> next_{0};
  int busy_ = 0;
  std::uint64_t loop_number_ = 0;
  bool stopping_ = false;
};

}  // namespace maille
