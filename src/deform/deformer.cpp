#include "deform/deformer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/failure.h"
#include "core/stopwatch.h"
#include "deform/carving.h"
#include "deform/cutting.h"

namespace maille {
namespace {

// Displacements are 32-bit; differences of two must be too.
constexpr double kFurthest_voxels = 1e6;

double furthest_voxels(const Lattice& lattice) {
  std::int32_t most = 0;
  lattice.for_each_brick([&](std::int64_t, const LatticeBrick& brick) {
    for (int c = 0; c < 3; ++c) {
      most = std::max({most, std::abs(brick.lowest()[c]), std::abs(brick.highest()[c])});
    }
  });
  return static_cast<double>(most) / kUnitsPerVoxel;
}

template <class Keep>
ElementSet filtered(const ElementSet& set, const BrickGrid& grid, Keep&& keep) {
  ElementSet kept;
  for (const auto& [linear, mask] : set.bricks()) {
    const VoxelBox box = grid.box(grid.brick(linear));
    for (int z = box.lo.z; z < box.hi.z; ++z) {
      for (int y = box.lo.y; y < box.hi.y; ++y) {
        for (int x = box.lo.x; x < box.hi.x; ++x) {
          const VoxelIndex voxel{x, y, z};
          if (!mask->test(static_cast<std::size_t>(element_in_brick(voxel)))) continue;
          if (keep(voxel)) kept.insert(voxel, grid);
        }
      }
    }
  }
  return kept;
}

// A carved element has no links: moving it would move nothing.
ElementSet not_carved(ElementSet set, const Cuts& cuts) {
  if (cuts.empty()) return set;
  return filtered(set, cuts.grid(), [&](VoxelIndex voxel) { return !cuts.carved(voxel); });
}

// Grabbing skin over bone must not hold on to the bone.
ElementSet movable(const ElementSet& set, const MaterialField& materials, AnchorRules anchors,
                   const BrickGrid& grid) {
  return filtered(set, grid, [&](VoxelIndex voxel) {
    return !(faces_of(voxel, grid.volume_size()) & anchors.faces) &&
           !materials.table().fixed(materials.at(voxel));
  });
}

std::string text_of(VoxelIndex voxel) {
  return "(" + std::to_string(voxel.x) + ", " + std::to_string(voxel.y) + ", " +
         std::to_string(voxel.z) + ")";
}

}  // namespace

StrokePeak peak_of(const DragReport& answer, const StrokeMemory& after) {
  return {after.start_bytes, after.gathered_bytes, answer.working_bytes, after.elements};
}

Deformer::Deformer(Volume volume, MaterialTable materials, AnchorRules anchors,
                   const DeformerOptions& options)
    : volume_(std::move(volume)),
      anchors_(anchors),
      now_{.lattice = Lattice(volume_.size()),
           .cuts = Cuts(volume_.size()),
           .handles = {},
           .kept = Lattice(volume_.size()),
           .released = {},
           .materials = std::make_shared<const MaterialTable>(std::move(materials)),
           .disturbance = {}},
      materials_(volume_, *now_.materials) {
  if (options.lattice_memory_bytes) memory_.emplace(*options.lattice_memory_bytes);
  if (options.undo_memory_bytes) history_.emplace(*options.undo_memory_bytes);
}

void Deformer::use_materials() { materials_ = MaterialField(volume_, *now_.materials); }

Result<void> Deformer::set_materials(MaterialTable table) {
  if (stroke_) return Error{ErrorKind::usage, "materials cannot change during a drag"};
  const Deformation before = now_;
  now_.materials = std::make_shared<const MaterialTable>(std::move(table));
  now_.disturbance.box = united(moved_box(now_.lattice), moved_box(now_.kept));
  use_materials();
  record_step(before);
  return {};
}

Result<void> Deformer::begin_stroke(VoxelIndex element, double radius_voxels, std::string name) {
  if (stroke_) return Error{ErrorKind::usage, "drag: a stroke is on already"};
  if (!contains(volume_.size(), element)) {
    return Error{ErrorKind::usage, "drag: voxel " + text_of(element) + " lies outside the volume"};
  }
  if (!(radius_voxels >= 0.0) || !std::isfinite(radius_voxels)) {
    return Error{ErrorKind::usage, "drag: expected a radius >= 0"};
  }
  const BrickGrid& grid = now_.lattice.grid();
  const ElementSet ball = not_carved(ball_of_elements(element, radius_voxels, grid), now_.cuts);
  if (ball.empty()) {
    return Error{ErrorKind::usage, "drag: all that could be grabbed at voxel " + text_of(element) +
                                       " is carved away"};
  }
  ElementSet grabbed = movable(ball, materials_, anchors_, grid);
  // All of it fixed: grab it as it is, and let the drag say that it is held.
  if (grabbed.empty()) grabbed = ball;
  std::vector<std::string> names;
  Handles others;
  for (const auto& handle : now_.handles) {
    if (handle->elements.intersects(ball)) {
      grabbed.insert(not_carved(handle->elements, now_.cuts));
      names.insert(names.end(), handle->names.begin(), handle->names.end());
    } else {
      others.push_back(handle);
    }
  }
  const auto taken = [&](const std::string& wanted) {
    return std::any_of(others.begin(), others.end(),
                       [&](const auto& handle) { return handle->has(wanted); });
  };
  if (!name.empty() && taken(name)) {
    return Error{ErrorKind::usage, "drag: another handle is named \"" + name + "\""};
  }
  for (int n = 1; name.empty() && names.empty(); ++n) {
    const std::string candidate = "handle " + std::to_string(n);
    if (!taken(candidate)) name = candidate;
  }
  if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) {
    names.push_back(std::move(name));
  }
  Stroke stroke;
  stroke.before = now_;
  now_.handles = std::move(others);
  stroke.pinned = std::make_unique<ElementSet>(pinned_elements());
  stroke.furthest_voxels = furthest_voxels(now_.lattice);
  stroke.bricks = std::make_unique<StrokeBricks>(materials_, now_.cuts, *stroke.pinned, anchors_);
  stroke.handle = {std::move(names), std::move(grabbed)};
  stroke_ = std::move(stroke);
  return {};
}

Result<DragReport> Deformer::drag_to(glm::dvec3 by_voxels, WorkerPool& pool) {
  if (!stroke_) return Error{ErrorKind::usage, "drag: no stroke is on"};
  glm::ivec3 by;
  for (int c = 0; c < 3; ++c) {
    if (!(stroke_->furthest_voxels + std::abs(by_voxels[c]) <= kFurthest_voxels)) {
      return Error{ErrorKind::usage,
                   "drag: expected nothing to be further than 1000000 voxels from where it rests"};
    }
    by[c] = static_cast<std::int32_t>(std::lround(by_voxels[c] * kUnitsPerVoxel));
  }
  const Stopwatch begin;
  // The answer to the last position is let go before the next one is made: a stroke is a function
  // of its start and the drag, so it can be made again, and never are there three states at once.
  // Material that has flown meanwhile, because of an earlier release, flows again from there.
  now_.lattice = stroke_->before.lattice;
  now_.kept = stroke_->before.kept;
  now_.released = stroke_->before.released;
  now_.disturbance = stroke_->before.disturbance;
  try {
    const ChainMailAnswer answer = solve(by, pool);
    stroke_->by = by;
    DragReport report;
    report.moved_by_voxels = glm::dvec3(answer.moved_by) / double{kUnitsPerVoxel};
    report.clamped = answer.clamped;
    report.elements_moved = answer.elements_moved;
    report.working_bytes = answer.working_bytes;
    report.seconds = begin.seconds();
    return report;
  } catch (const Failure& failure) {
    try {
      solve(stroke_->by, pool);
    } catch (const Failure&) {
      // The scratch file fails whatever is asked: the stroke stands at its start.
      stroke_->by = glm::ivec3(0);
    }
    return Error{failure.error().kind, "drag: " + failure.error().message};
  }
}

// Drags the handle by so many units from where the stroke began. Throws what solve_chainmail()
// throws, and Failure for what does not fit the lattice's memory.
ChainMailAnswer Deformer::solve(glm::ivec3 by, WorkerPool& pool) {
  const Lattice& start = stroke_->before.lattice;
  ChainMailProblem problem{start, *stroke_->bricks, stroke_->handle.elements};
  if (memory_) problem.most_label_bytes = memory_->store().budget_bytes();
  ChainMailAnswer answer = solve_chainmail(problem, by, pool);
  if (memory_) {
    if (auto fits = memory_->check(start, answer.lattice); !fits) throw Failure(fits.error());
    memory_->take_in(start, answer.lattice);
  }
  now_.disturbance.box = united(now_.disturbance.box, difference_box(start, answer.lattice));
  now_.lattice = std::move(answer.lattice);
  return answer;
}

StrokeMemory Deformer::stroke_memory() const {
  if (!stroke_) return {};
  const Lattice& now = now_.lattice;
  const Lattice& before = stroke_->before.lattice;
  const BrickGrid& grid = now.grid();
  StrokeMemory memory{now.bytes(), before.bytes(), stroke_->bricks->bytes(), 0};
  const auto count = [&](std::int64_t linear) {
    memory.elements += voxel_count(grid.box(grid.brick(linear)).size());
  };
  now.for_each_brick([&](std::int64_t linear, const LatticeBrick&) { count(linear); });
  Lattice::for_each_difference(now, before, [&](std::int64_t linear) {
    const LatticeBrick* const was = before.brick(linear);
    if (!was) return;
    const LatticeBrick* const is = now.brick(linear);
    memory.lattice_bytes += was->bytes();
    for (int c = 0; is && c < 3; ++c) {
      if (was->plane(c) && was->plane(c) == is->plane(c)) {
        memory.lattice_bytes -= was->plane(c)->bytes();
      }
    }
    if (!is) count(linear);
  });
  return memory;
}

void Deformer::end_stroke() {
  if (!stroke_) return;
  now_.handles.push_back(std::make_shared<const Handle>(std::move(stroke_->handle)));
  const Deformation before = std::move(stroke_->before);
  stroke_.reset();
  record_step(before);
}

void Deformer::cancel_stroke() {
  if (!stroke_) return;
  now_ = std::move(stroke_->before);
  stroke_.reset();
}

Result<void> Deformer::cut(const CutSurface& surface) {
  if (stroke_) return Error{ErrorKind::usage, "cut: a stroke is on"};
  auto cuts = cut_along(now_.cuts, now_.lattice, surface);
  if (!cuts) return cuts.error();
  take_over(*std::move(cuts));
  return {};
}

Result<void> Deformer::check_ball(const char* action, glm::dvec3 center, double radius) const {
  const auto refuse = [&](const char* sentence) {
    return Error{ErrorKind::usage, std::string(action) + ": " + sentence};
  };
  if (stroke_) return refuse("a stroke is on");
  if (!(radius >= 0.0) || !std::isfinite(radius)) return refuse("expected a radius >= 0");
  for (int c = 0; c < 3; ++c) {
    if (!std::isfinite(center[c])) return refuse("expected a finite centre");
  }
  return {};
}

Result<void> Deformer::carve(glm::dvec3 center_voxel, double radius_voxels) {
  if (auto checked = check_ball("carve", center_voxel, radius_voxels); !checked) return checked;
  take_over(maille::carve(now_.cuts, now_.lattice, center_voxel, radius_voxels));
  return {};
}

Result<void> Deformer::restore(glm::dvec3 center_voxel, double radius_voxels) {
  if (auto checked = check_ball("restore", center_voxel, radius_voxels); !checked) return checked;
  take_over(maille::restore(now_.cuts, now_.lattice, center_voxel, radius_voxels));
  return {};
}

void Deformer::take_over(Cuts cuts) {
  bool changed = false;
  Cuts::for_each_difference(now_.cuts, cuts, [&](std::int64_t) { changed = true; });
  if (!changed) return;
  const Deformation before = now_;
  now_.cuts = std::move(cuts);
  for (const Lattice* lattice : {&now_.lattice, &now_.kept}) {
    now_.disturbance.box =
        united(now_.disturbance.box, difference_box(before.cuts, now_.cuts, *lattice));
  }
  record_step(before);
}

Result<void> Deformer::release(const std::string& name) {
  if (stroke_) return Error{ErrorKind::usage, "release: a stroke is on"};
  const auto found = std::find_if(now_.handles.begin(), now_.handles.end(),
                                  [&](const auto& handle) { return handle->has(name); });
  if (found == now_.handles.end()) {
    std::string known;
    for (const std::string& n : handle_names()) known += (known.empty() ? "\"" : ", \"") + n + "\"";
    return Error{ErrorKind::usage, "release: no handle is named \"" + name + "\"; " +
                                       (known.empty() ? "there are none" : "there are " + known)};
  }
  const Deformation before = now_;
  let_loose(*found);
  now_.handles.erase(found);
  record_step(before);
  return {};
}

void Deformer::release_all() {
  if (stroke_ || now_.handles.empty()) return;
  const Deformation before = now_;
  for (const auto& handle : now_.handles) let_loose(handle);
  now_.handles.clear();
  record_step(before);
}

// What was held may move, and pulls at what is around it.
void Deformer::let_loose(const std::shared_ptr<const Handle>& handle) {
  now_.disturbance.box =
      united(now_.disturbance.box, box_of(handle->elements, now_.lattice.grid()));
  if (now_.materials->any_yields()) now_.released.push_back(handle);
}

std::vector<std::string> Deformer::handle_names() const {
  std::vector<std::string> names;
  for (const auto& handle : now_.handles) {
    names.insert(names.end(), handle->names.begin(), handle->names.end());
  }
  return names;
}

ElementSet Deformer::pinned_elements() const {
  ElementSet pinned;
  for (const auto& handle : now_.handles) pinned.insert(handle->elements);
  return pinned;
}

ElementSet Deformer::held_elements() const {
  ElementSet held = pinned_elements();
  if (stroke_) held.insert(stroke_->handle.elements);
  return held;
}

std::optional<VoxelBox> Deformer::disturbed(double tolerance_voxels) const {
  if (tolerance_voxels < now_.disturbance.elsewhere_voxels) return std::nullopt;
  return now_.disturbance.box;
}

Yielding Deformer::yielding() const {
  Yielding yielding{now_.kept, {}};
  for (const auto& handle : now_.released) yielding.released.insert(handle->elements);
  return yielding;
}

RelaxationStart Deformer::relaxation_start(double tolerance_voxels) const {
  return {now_.lattice,    materials_, now_.cuts,
          held_elements(), anchors_,   disturbed(tolerance_voxels),
          yielding()};
}

Relaxation Deformer::relax(WorkerPool& pool, const RelaxationOptions& options) const {
  return Relaxation(now_.lattice, materials_, now_.cuts, held_elements(), anchors_, pool, options,
                    disturbed(options.tolerance_voxels), yielding());
}

void Deformer::adopt(Lattice relaxed, std::optional<double> finished_within_voxels,
                     const Lattice* kept) {
  if (memory_) memory_->take_in(now_.lattice, relaxed);
  if (memory_ && kept) memory_->take_in(now_.kept, *kept);
  const Deformation before = now_;
  now_.lattice = std::move(relaxed);
  if (kept) {
    now_.kept = *kept;
    now_.released.clear();
  }
  if (finished_within_voxels) {
    now_.disturbance = {VoxelBox{}, *finished_within_voxels};
  } else {
    // A region that grows moves what nothing had disturbed.
    now_.disturbance.box =
        united(now_.disturbance.box, difference_box(before.lattice, now_.lattice));
    now_.disturbance.box = united(now_.disturbance.box, difference_box(before.kept, now_.kept));
  }
  // A stroke that is on becomes one step as a whole.
  if (stroke_) return;
  if (history_) history_->extend(before, now_);
  prefer_present(before);
}

// What only undo would bring back is put aside first.
void Deformer::prefer_present(const Deformation& before) {
  if (!memory_) return;
  memory_->prefer(now_.lattice, before.lattice);
  memory_->prefer(now_.kept, before.kept);
}

void Deformer::mark_undo_step() { record_step(now_); }

void Deformer::record_step(const Deformation& before) {
  if (stroke_) return;
  if (history_) history_->record(before, now_);
  prefer_present(before);
}

bool Deformer::undo() { return walk(&History::undo); }

bool Deformer::redo() { return walk(&History::redo); }

bool Deformer::walk(bool (History::*step)(Deformation&)) {
  if (!history_ || stroke_) return false;
  const Deformation before = now_;
  if (!((*history_).*step)(now_)) return false;
  if (now_.materials != before.materials) use_materials();
  prefer_present(before);
  return true;
}

}  // namespace maille
