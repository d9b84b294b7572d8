#include "core/parallel.h"

#include <algorithm>
#include <utility>

#include "core/trace.h"

namespace maille {

WorkerPool::WorkerPool(int threads) {
  if (threads <= 0) threads = std::max(1u, std::thread::hardware_concurrency());
  for (int worker = 1; worker < threads; ++worker) {
    threads_.emplace_back([this, worker] { work(worker); });
  }
}

WorkerPool::~WorkerPool() {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  threads_.clear();  // joins them, while there still is what they wait on
}

void WorkerPool::loop(std::int64_t count, const std::function<void(std::int64_t, int)>& f,
                      const std::atomic<bool>* give_up) {
  // What has been given up keeps nobody waiting, not even for its turn.
  if (give_up && give_up->load(std::memory_order_relaxed)) throw Interrupted();
  std::unique_lock lock(mutex_);
  const std::uint64_t turn = turns_given_++;
  turn_over_.wait(lock, [&] { return turn == turn_; });
  body_ = &f;
  body_gives_up_ = give_up;
  count_ = count;
  next_.store(0, std::memory_order_relaxed);
  if (threads_.empty() || count <= 1) {
    lock.unlock();
    take_items(0);
    lock.lock();
  } else {
    busy_ = static_cast<int>(threads_.size());
    ++loop_number_;
    lock.unlock();
    wake_.notify_all();
    take_items(0);
    lock.lock();
    done_.wait(lock, [this] { return busy_ == 0; });
  }
  body_ = nullptr;
  const std::exception_ptr thrown = std::exchange(thrown_, nullptr);
  ++turn_;
  lock.unlock();
  turn_over_.notify_all();
  if (thrown) std::rethrow_exception(thrown);
}

void WorkerPool::take_items(int worker) {
  for (;;) {
    const std::int64_t index = next_.fetch_add(1, std::memory_order_relaxed);
    if (index >= count_) return;
    try {
      if (body_gives_up_ && body_gives_up_->load(std::memory_order_relaxed)) throw Interrupted();
      (*body_)(index, worker);
    } catch (...) {
      next_.store(count_, std::memory_order_relaxed);  // nobody takes another
      std::lock_guard lock(mutex_);
      if (!thrown_) thrown_ = std::current_exception();
      return;
    }
  }
}

void WorkerPool::work(int worker) {
  trace::name_this_thread("worker " + std::to_string(worker));
  std::uint64_t seen = 0;
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return stopping_ || loop_number_ != seen; });
      if (stopping_) return;
      seen = loop_number_;
    }
    take_items(worker);
    {
      std::lock_guard lock(mutex_);
      if (--busy_ == 0) done_.notify_one();
    }
  }
}

}  // namespace maille
