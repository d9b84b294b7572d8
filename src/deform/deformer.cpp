#include "deform/deformer.h"

#include <algorithm>
#include <cmath>

#include "core/stopwatch.h"

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

// The elements of a set that may move: grabbing skin over bone must not hold on to the bone.
ElementSet movable(const ElementSet& set, const MaterialField& materials, AnchorRules anchors,
                   const BrickGrid& grid) {
  ElementSet kept;
  for (const auto& [linear, mask] : set.bricks()) {
    const VoxelBox box = grid.box(grid.brick(linear));
    for (int z = box.lo.z; z < box.hi.z; ++z) {
      for (int y = box.lo.y; y < box.hi.y; ++y) {
        for (int x = box.lo.x; x < box.hi.x; ++x) {
          const VoxelIndex voxel{x, y, z};
          if (!mask->test(static_cast<std::size_t>(element_in_brick(voxel)))) continue;
          if (faces_of(voxel, grid.volume_size()) & anchors.faces) continue;
          if (materials.table().fixed(materials.at(voxel))) continue;
          kept.insert(voxel, grid);
        }
      }
    }
  }
  return kept;
}

}  // namespace

bool Deformer::Handle::has(const std::string& name) const {
  return std::find(names.begin(), names.end(), name) != names.end();
}

Deformer::Deformer(Volume volume, MaterialTable materials, AnchorRules anchors)
    : materials_(volume, std::move(materials)),
      volume_(std::move(volume)),
      anchors_(anchors),
      lattice_(volume_.size()) {}

void Deformer::set_materials(MaterialTable table) {
  materials_ = MaterialField(volume_, std::move(table));
}

Result<void> Deformer::begin_stroke(VoxelIndex element, double radius_voxels, std::string name) {
  if (stroke_) return Error{ErrorKind::usage, "drag: a stroke is on already"};
  if (!contains(volume_.size(), element)) {
    return Error{ErrorKind::usage, "drag: voxel (" + std::to_string(element.x) + ", " +
                                       std::to_string(element.y) + ", " +
                                       std::to_string(element.z) + ") lies outside the volume"};
  }
  if (!(radius_voxels >= 0.0) || !std::isfinite(radius_voxels)) {
    return Error{ErrorKind::usage, "drag: expected a radius >= 0"};
  }
  const BrickGrid& grid = lattice_.grid();
  Stroke stroke;
  stroke.before = {lattice_, handles_};
  const ElementSet ball = ball_of_elements(element, radius_voxels, grid);
  ElementSet grabbed = movable(ball, materials_, anchors_, grid);
  // All of it fixed: grab it as it is, and let the drag say that it is held.
  if (grabbed.empty()) grabbed = ball;
  std::vector<std::string> names;
  std::vector<Handle> others;
  for (Handle& handle : handles_) {
    if (handle.elements.intersects(ball)) {
      grabbed.insert(handle.elements);
      names.insert(names.end(), handle.names.begin(), handle.names.end());
    } else {
      others.push_back(std::move(handle));
    }
  }
  const auto taken = [&](const std::string& wanted) {
    return std::any_of(others.begin(), others.end(),
                       [&](const Handle& handle) { return handle.has(wanted); });
  };
  if (!name.empty() && taken(name)) {
    handles_ = std::move(stroke.before.handles);
    return Error{ErrorKind::usage, "drag: another handle is named \"" + name + "\""};
  }
  for (int n = 1; name.empty() && names.empty(); ++n) {
    const std::string candidate = "handle " + std::to_string(n);
    if (!taken(candidate)) name = candidate;
  }
  if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) {
    names.push_back(std::move(name));
  }
  handles_ = std::move(others);
  stroke.pinned = pinned_elements();
  stroke.furthest_voxels = furthest_voxels(lattice_);
  stroke.halos = std::make_unique<MaterialHalos>(materials_, grid);
  stroke.handle = {std::move(names), std::move(grabbed)};
  stroke_ = std::move(stroke);
  return {};
}

Result<DragReport> Deformer::drag_to(glm::dvec3 by_voxels) {
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
  const ChainMailProblem problem{stroke_->before.lattice, *stroke_->halos, stroke_->handle.elements,
                                 stroke_->pinned, anchors_};
  ChainMailAnswer answer = solve_chainmail(problem, by);
  lattice_ = std::move(answer.lattice);
  DragReport report;
  report.moved_by_voxels = glm::dvec3(answer.moved_by) / double{kUnitsPerVoxel};
  report.clamped = answer.clamped;
  report.elements_moved = answer.elements_moved;
  report.seconds = begin.seconds();
  return report;
}

void Deformer::end_stroke() {
  if (!stroke_) return;
  undo_.push_back(std::move(stroke_->before));
  redo_.clear();
  handles_.push_back(std::move(stroke_->handle));
  stroke_.reset();
}

void Deformer::cancel_stroke() {
  if (!stroke_) return;
  lattice_ = std::move(stroke_->before.lattice);
  handles_ = std::move(stroke_->before.handles);
  stroke_.reset();
}

Result<void> Deformer::release(const std::string& name) {
  const auto found =
      std::find_if(handles_.begin(), handles_.end(), [&](const Handle& h) { return h.has(name); });
  if (found == handles_.end()) {
    std::string known;
    for (const std::string& n : handle_names()) known += (known.empty() ? "\"" : ", \"") + n + "\"";
    return Error{ErrorKind::usage, "release: no handle is named \"" + name + "\"; " +
                                       (known.empty() ? "there are none" : "there are " + known)};
  }
  mark_undo_step();
  handles_.erase(found);
  return {};
}

void Deformer::release_all() {
  if (handles_.empty()) return;
  mark_undo_step();
  handles_.clear();
}

std::vector<std::string> Deformer::handle_names() const {
  std::vector<std::string> names;
  for (const Handle& handle : handles_) {
    names.insert(names.end(), handle.names.begin(), handle.names.end());
  }
  return names;
}

ElementSet Deformer::pinned_elements() const {
  ElementSet pinned;
  for (const Handle& handle : handles_) pinned.insert(handle.elements);
  return pinned;
}

Relaxation Deformer::relax(WorkerPool& pool, const RelaxationOptions& options) const {
  ElementSet held = pinned_elements();
  if (stroke_) held.insert(stroke_->handle.elements);
  return Relaxation(lattice_, materials_, Cuts(volume_.size()), held, anchors_, pool, options);
}

void Deformer::adopt(Lattice relaxed) { lattice_ = std::move(relaxed); }

void Deformer::mark_undo_step() {
  undo_.push_back({lattice_, handles_});
  redo_.clear();
}

bool Deformer::undo() {
  if (undo_.empty() || stroke_) return false;
  redo_.push_back({std::move(lattice_), std::move(handles_)});
  lattice_ = std::move(undo_.back().lattice);
  handles_ = std::move(undo_.back().handles);
  undo_.pop_back();
  return true;
}

bool Deformer::redo() {
  if (redo_.empty() || stroke_) return false;
  undo_.push_back({std::move(lattice_), std::move(handles_)});
  lattice_ = std::move(redo_.back().lattice);
  handles_ = std::move(redo_.back().handles);
  redo_.pop_back();
  return true;
}

}  // namespace maille
