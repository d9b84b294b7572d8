#include "app/relaxer.h"

#include <chrono>
#include <new>
#include <utility>

#include "core/failure.h"
#include "core/trace.h"

namespace maille {
namespace {

// Rounding and resampling a state costs about as much as relaxing on: show it at this pace.
constexpr double kPace_seconds = 0.05;

double now_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

Relaxer::Relaxer(WorkerPool& pool, std::function<void()> reached)
    : pool_(pool), reached_(std::move(reached)), thread_([this] { run(); }) {}

Relaxer::~Relaxer() {
  give_up();
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  called_.notify_one();
}

void Relaxer::start(RelaxationStart from, const RelaxationOptions& options) {
  auto job = std::make_shared<Job>(std::move(from), options);
  give_up();
  {
    const std::lock_guard lock(mutex_);
    job_ = next_ = std::move(job);
    status_ = {.at_work = true, .progress = {}};
  }
  called_.notify_one();
}

void Relaxer::give_up() {
  std::optional<Result<Reached>> dropped;
  std::shared_ptr<Job> never_begun;
  {
    const std::lock_guard lock(mutex_);
    if (job_) job_->given_up = true;
    job_.reset();
    never_begun = std::exchange(next_, nullptr);
    dropped = std::exchange(reached_state_, std::nullopt);
    status_ = {};
  }
  called_.notify_one();
}

void Relaxer::pause(bool paused) {
  {
    const std::lock_guard lock(mutex_);
    paused_ = paused;
  }
  called_.notify_one();
}

void Relaxer::want_state(bool wanted) {
  const std::lock_guard lock(mutex_);
  wanted_ = wanted;
}

std::optional<Result<Relaxer::Reached>> Relaxer::take() {
  const std::lock_guard lock(mutex_);
  if (reached_state_ && !job_) status_.at_work = false;
  return std::exchange(reached_state_, std::nullopt);
}

Relaxer::Status Relaxer::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

void Relaxer::run() {
  trace::name_this_thread("relaxation");
  for (;;) {
    std::shared_ptr<Job> job;
    {
      std::unique_lock lock(mutex_);
      called_.wait(lock, [this] { return stopping_ || next_; });
      if (stopping_) return;
      job = std::exchange(next_, nullptr);
    }
    relax(*job);
  }
}

void Relaxer::relax(Job& job) {
  try {
    work(job);
  } catch (const Interrupted&) {
    // Nobody waits for it.
  } catch (const std::bad_alloc&) {
    leave(job, Error{ErrorKind::out_of_memory, "out of memory: relaxation was given up"});
  } catch (const Failure& failure) {
    leave(job, failure.error());
  }
}

void Relaxer::work(Job& job) {
  if (!may_go_on(job)) return;
  WorkerPool guest(pool_, job.given_up);
  Relaxation relaxation = job.from.relax(guest, job.options);
  for (;;) {
    tell(job, relaxation.progress());
    if (!may_go_on(job)) return;
    const bool finished = relaxation.progress().finished();
    if (finished || (relaxation.progress().iterations > 0 && state_is_wanted())) {
      Reached reached{relaxation.lattice(), finished};
      if (const Lattice* const kept = relaxation.kept_by_flow()) reached.kept = *kept;
      leave(job, std::move(reached));
    }
    if (finished) return;
    const trace::Span span("relax");
    relaxation.iterate();
  }
}

bool Relaxer::may_go_on(const Job& job) {
  std::unique_lock lock(mutex_);
  called_.wait(lock, [&] { return !paused_ || job.given_up; });
  return !job.given_up;
}

bool Relaxer::state_is_wanted() const {
  const std::lock_guard lock(mutex_);
  return wanted_ && now_seconds() - left_seconds_ > kPace_seconds;
}

void Relaxer::tell(const Job& job, const RelaxationProgress& progress) {
  const std::lock_guard lock(mutex_);
  if (!job.given_up) status_.progress = progress;
}

void Relaxer::leave(const Job& job, Result<Reached> what) {
  {
    const std::lock_guard lock(mutex_);
    if (job.given_up) return;
    if (!what.ok() || (*what).finished) job_.reset();
    reached_state_ = std::move(what);
    left_seconds_ = now_seconds();
  }
  reached_();
}

}  // namespace maille
