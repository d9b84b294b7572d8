#include "app/simulation.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <new>
#include <utility>

#include "core/failure.h"
#include "core/trace.h"

namespace maille {
namespace {

// Longest stretch of relaxation between two looks at what is asked for.
constexpr double kRelaxSlice_seconds = 0.008;
// Rounding and resampling a state costs as much as relaxing on: show it at this pace.
constexpr double kPublishPace_seconds = 0.1;

double now_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

Simulation::Simulation(Document& document, std::function<void()> wake)
    : document_(document), wake_(std::move(wake)), thread_([this] { run(); }) {}

Simulation::~Simulation() {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  asked_.notify_one();
  thread_.join();
}

void Simulation::ask(Wish wish) {
  {
    std::lock_guard lock(mutex_);
    // A drag that was asked for before comes before.
    if (drag_target_) {
      wishes_.push_back([this, by = *drag_target_] { return drag_now(by); });
      drag_target_.reset();
    }
    wishes_.push_back(std::move(wish));
  }
  asked_.notify_one();
}

void Simulation::drag_to(glm::dvec3 by_voxels) {
  {
    std::lock_guard lock(mutex_);
    drag_target_ = by_voxels;
  }
  asked_.notify_one();
}

void Simulation::grab(VoxelIndex element, double radius_voxels) {
  ask([=, this] {
    stop_relaxing();
    dragged_ = false;
    return document_.deformer().begin_stroke(element, radius_voxels);
  });
}

void Simulation::let_go() {
  ask([this]() -> Result<void> {
    if (!document_.deformer().in_stroke()) return {};
    if (dragged_) {
      document_.deformer().end_stroke();
    } else {
      document_.deformer().cancel_stroke();
    }
    if (!relaxation_) start_relaxing();
    return {};
  });
}

void Simulation::cancel() {
  ask([this]() -> Result<void> {
    if (!document_.deformer().in_stroke()) return {};
    document_.deformer().cancel_stroke();
    changed_at_once();
    return {};
  });
}

void Simulation::release_pins() {
  ask([this]() -> Result<void> {
    if (document_.deformer().in_stroke() || document_.deformer().handle_names().empty()) return {};
    stop_relaxing();
    document_.deformer().release_all();
    start_relaxing();
    return {};
  });
}

void Simulation::undo() {
  ask([this]() -> Result<void> {
    if (!document_.deformer().undo()) return Error{ErrorKind::usage, "nothing to undo"};
    changed_at_once();
    return {};
  });
}

void Simulation::redo() {
  ask([this]() -> Result<void> {
    if (!document_.deformer().redo()) return Error{ErrorKind::usage, "nothing to redo"};
    changed_at_once();
    return {};
  });
}

void Simulation::changed_at_once() {
  relaxation_.reset();
  unpublished_ = true;
  start_relaxing();
}

void Simulation::set_materials(MaterialTable table) {
  ask([this, table = std::move(table)]() -> Result<void> {
    if (document_.deformer().in_stroke()) {
      return Error{ErrorKind::usage, "materials cannot change during a drag"};
    }
    stop_relaxing();
    auto set = document_.deformer().set_materials(table);
    start_relaxing();
    return set;
  });
}

void Simulation::pause_or_resume_relaxation() {
  ask([this]() -> Result<void> {
    update_status([](SimulationStatus& s) { s.paused = !s.paused; });
    return {};
  });
}

std::optional<ViewUpdate> Simulation::take_view() {
  std::lock_guard lock(mutex_);
  return std::exchange(view_, std::nullopt);
}

SimulationStatus Simulation::status() const {
  std::lock_guard lock(mutex_);
  return status_;
}

template <class F>
void Simulation::update_status(F&& change) {
  std::lock_guard lock(mutex_);
  change(status_);
}

void Simulation::run() {
  trace::name_this_thread("simulation");
  for (;;) {
    Wish wish;
    {
      std::unique_lock lock(mutex_);
      const bool at_work = (relaxation_ && !status_.paused) || unpublished_;
      const auto called = [&] { return stopping_ || !wishes_.empty() || drag_target_; };
      if (!at_work) asked_.wait(lock, called);
      if (stopping_) return;
      if (!wishes_.empty()) {
        wish = std::move(wishes_.front());
        wishes_.pop_front();
      } else if (drag_target_) {
        wish = [this, by = *drag_target_] { return drag_now(by); };
        drag_target_.reset();
      }
    }
    try {
      if (wish) {
        fulfil(wish);
      } else if (relaxation_) {
        relax_for_a_moment();
      }
      if (unpublished_) publish();
    } catch (const std::bad_alloc&) {
      give_up("out of memory: the last step was given up");
    } catch (const Failure& failure) {
      give_up(failure.error().message);
    }
  }
}

// The lattice is as the last finished step left it; relaxing on would only ask again.
void Simulation::give_up(const std::string& reason) {
  relaxation_.reset();
  unpublished_ = false;
  update_status([&](SimulationStatus& s) {
    s.refused = reason;
    s.relaxing = false;
  });
  wake_();
}

void Simulation::fulfil(const Wish& wish) {
  const auto done = wish();
  update_status([&](SimulationStatus& s) {
    s.refused = done.ok() ? "" : done.error().message;
    s.pins = static_cast<int>(document_.deformer().handle_names().size());
    s.undo_steps_dropped = document_.undo_steps_dropped();
    s.relaxing = relaxation_.has_value();
  });
  wake_();
}

Result<void> Simulation::drag_now(glm::dvec3 by_voxels) {
  if (!document_.deformer().in_stroke()) return {};
  relaxation_.reset();
  dragged_ = true;
  const auto report = document_.deformer().drag_to(by_voxels, document_.pool());
  if (!report) return report.error();
  update_status([&](SimulationStatus& s) {
    s.elements_moved = report->elements_moved;
    s.drag_ms = 1e3 * report->seconds;
    s.clamped = report->clamped;
  });
  unpublished_ = true;
  publish();
  start_relaxing();
  return {};
}

void Simulation::start_relaxing() {
  update_status([](SimulationStatus& s) { s.converged = false; });
  if (!document_.plan().relaxation || document_.lattice().at_rest()) return;
  // Another target may be waiting already: making springs for a shape that is gone is wasted.
  {
    std::lock_guard lock(mutex_);
    if (drag_target_) return;
  }
  RelaxationOptions options;
  options.tolerance_voxels = document_.scene().relaxation.tolerance_voxels;
  relaxation_.emplace(document_.deformer().relax(document_.pool(), options));
}

void Simulation::stop_relaxing() {
  if (!relaxation_) return;
  document_.deformer().adopt(relaxation_->lattice());
  relaxation_.reset();
  unpublished_ = true;
}

void Simulation::relax_for_a_moment() {
  const trace::Span span("relax");
  const double begin = now_seconds();
  const RelaxationProgress* progress = &relaxation_->progress();
  while (!progress->finished() && now_seconds() - begin < kRelaxSlice_seconds) {
    progress = &relaxation_->iterate();
  }
  const bool done = progress->finished();
  update_status([&](SimulationStatus& s) {
    s.relaxing = !done;
    s.converged = progress->converged;
    s.residual_voxels = progress->residual_voxels;
    s.iterations = progress->iterations;
  });
  const bool taken = [&] {
    std::lock_guard lock(mutex_);
    return !view_.has_value();
  }();
  if (done) {
    stop_relaxing();
  } else if (taken && now_seconds() - last_publish_seconds_ > kPublishPace_seconds) {
    document_.deformer().adopt(relaxation_->lattice());
    unpublished_ = true;
  }
}

void Simulation::publish() {
  ViewUpdate update = document_.take_view();
  unpublished_ = false;
  last_publish_seconds_ = now_seconds();
  {
    std::lock_guard lock(mutex_);
    if (view_) {
      std::vector<std::int64_t> bricks;
      std::set_union(view_->bricks.begin(), view_->bricks.end(), update.bricks.begin(),
                     update.bricks.end(), std::back_inserter(bricks));
      update.bricks = std::move(bricks);
    }
    view_ = std::move(update);
  }
  wake_();
}

}  // namespace maille
