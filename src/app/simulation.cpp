#include "app/simulation.h"

#include <algorithm>
#include <iterator>
#include <new>
#include <utility>

#include "core/failure.h"
#include "core/trace.h"

namespace maille {
Simulation::Simulation(Document& document, std::function<void()> wake)
    : document_(document),
      wake_(std::move(wake)),
      volume_elements_(voxel_count(document.volume().size())),
      tolerance_voxels_(document.scene().relaxation.tolerance_voxels),
      relaxer_(document.pool(),
               [this] {
                 {
                   const std::lock_guard lock(mutex_);
                   reached_ = true;
                 }
                 asked_.notify_one();
               }),
      thread_([this] { run(); }) {}

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
    relaxer_.give_up();
    dragged_ = false;
    auto begun = document_.deformer().begin_stroke(element, radius_voxels);
    if (!begun) start_relaxing();
    return begun;
  });
}

void Simulation::let_go() {
  ask([this]() -> Result<void> {
    if (!document_.deformer().in_stroke()) return {};
    if (dragged_) {
      document_.deformer().end_stroke();  // and relaxation goes on
    } else {
      document_.deformer().cancel_stroke();
      start_relaxing();
    }
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
    relaxer_.give_up();
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
  relaxer_.give_up();
  unpublished_ = true;
  start_relaxing();
}

void Simulation::set_materials(MaterialTable table) {
  ask([this, table = std::move(table)]() -> Result<void> {
    if (document_.deformer().in_stroke()) {
      return Error{ErrorKind::usage, "materials cannot change during a drag"};
    }
    relaxer_.give_up();
    auto set = document_.deformer().set_materials(table);
    start_relaxing();
    return set;
  });
}

void Simulation::pause_or_resume_relaxation() {
  ask([this]() -> Result<void> {
    bool paused = false;
    update_status([&](SimulationStatus& s) { paused = s.paused = !s.paused; });
    relaxer_.pause(paused);
    return {};
  });
}

std::optional<ViewUpdate> Simulation::take_view() {
  std::optional<ViewUpdate> taken;
  {
    std::lock_guard lock(mutex_);
    taken = std::exchange(view_, std::nullopt);
  }
  if (taken) relaxer_.want_state(true);
  return taken;
}

SimulationStatus Simulation::status() const {
  const Relaxer::Status relaxation = relaxer_.status();
  const RelaxationProgress& progress = relaxation.progress;
  std::lock_guard lock(mutex_);
  SimulationStatus status = status_;
  status.relaxing = relaxation.at_work;
  status.converged = progress.converged;
  status.no_nearer = progress.no_nearer;
  status.residual_voxels = progress.residual_voxels;
  status.residual_rms_voxels = progress.residual_rms_voxels;
  status.iterations = progress.iterations;
  status.free_elements = progress.free_elements;
  status.region_limited = progress.region_limited;
  status.volume_elements = volume_elements_;
  return status;
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
      const auto called = [&] {
        return stopping_ || !wishes_.empty() || drag_target_ || reached_ || wants_to_relax_;
      };
      asked_.wait(lock, called);
      if (stopping_) return;
      if (!wishes_.empty()) {
        wish = std::move(wishes_.front());
        wishes_.pop_front();
      } else if (drag_target_) {
        wish = [this, by = *drag_target_] { return drag_now(by); };
        drag_target_.reset();
      } else {
        reached_ = false;
      }
    }
    try {
      if (wish) {
        fulfil(wish);
      } else if (auto reached = relaxer_.take()) {
        adopt(*std::move(reached));
      } else if (std::exchange(wants_to_relax_, false)) {
        start_now();
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
  relaxer_.give_up();
  wants_to_relax_ = false;
  unpublished_ = false;
  update_status([&](SimulationStatus& s) { s.refused = reason; });
  wake_();
}

void Simulation::fulfil(const Wish& wish) {
  const auto done = wish();
  update_status([&](SimulationStatus& s) {
    s.refused = done.ok() ? "" : done.error().message;
    s.pins = static_cast<int>(document_.deformer().handle_names().size());
    s.undo_steps_dropped = document_.undo_steps_dropped();
  });
  wake_();
}

Result<void> Simulation::drag_now(glm::dvec3 by_voxels) {
  if (!document_.deformer().in_stroke()) return {};
  relaxer_.give_up();
  start_relaxing();
  dragged_ = true;
  const auto report = document_.deformer().drag_to(by_voxels, document_.pool());
  if (!report) return report.error();
  update_status([&](SimulationStatus& s) {
    s.elements_moved = report->elements_moved;
    s.drag_ms = 1e3 * report->seconds;
    s.clamped = report->clamped;
  });
  unpublished_ = true;
  return {};
}

// Once nothing else is asked: springs for a shape that is gone already would be wasted.
void Simulation::start_relaxing() { wants_to_relax_ = true; }

void Simulation::start_now() {
  const bool at_rest = document_.lattice().at_rest() && document_.deformer().kept().at_rest();
  if (!document_.plan().relaxation || at_rest) return;
  RelaxationOptions options;
  options.tolerance_voxels = tolerance_voxels_;
  options.memory_bytes = document_.relaxation_memory_bytes();
  relaxer_.start(document_.deformer().relaxation_start(options.tolerance_voxels), options);
}

void Simulation::adopt(Result<Relaxer::Reached> reached) {
  if (!reached) {
    give_up(reached.error().message);
    return;
  }
  std::optional<double> finished_within_voxels;
  if (reached->finished) finished_within_voxels = tolerance_voxels_;
  document_.deformer().adopt(std::move(reached->lattice), finished_within_voxels,
                             reached->kept ? &*reached->kept : nullptr);
  unpublished_ = true;
}

void Simulation::publish() {
  ViewUpdate update = document_.take_view();
  unpublished_ = false;
  // Before anybody can take it: who takes it wants the next one.
  relaxer_.want_state(false);
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
