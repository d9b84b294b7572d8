// A change of what has been taken out of a lattice, link by link. Bricks that end up as they were
// stay the same shared bricks, and those in which nothing is removed any more go.
#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>

#include "deform/cuts.h"

namespace maille {

class CutsEdit {
 public:
  explicit CutsEdit(const Cuts& cuts) : cuts_(cuts) {}

  // Both see the changes made so far. Voxels must lie in the volume.
  bool carved(VoxelIndex voxel) const;
  bool removed(VoxelIndex lower, int axis) const;

  // `lower` must have a next element along the axis.
  void set_removed(VoxelIndex lower, int axis, bool removed);
  void set_carved(VoxelIndex voxel, bool carved);

  Cuts finish();

 private:
  // The brick last asked for: neighbours nearly always lie in the same one.
  struct Current {
    std::int64_t linear = -1;
    const CutBrick* brick = nullptr;
    CutBrick* changing = nullptr;  // null: not a copy of our own yet
  };

  const CutBrick* brick(VoxelIndex voxel) const;
  CutBrick& changing(VoxelIndex voxel);

  Cuts cuts_;
  std::unordered_map<std::int64_t, std::shared_ptr<CutBrick>> changed_;
  mutable Current current_;
};

// Calls f(lower, axis, other) for each link of an element in a volume: its lower element, its axis
// and its other end.
template <class F>
void for_each_link(VoxelIndex voxel, Size3 size, F&& f) {
  for (int axis = 0; axis < 3; ++axis) {
    VoxelIndex next = voxel;
    VoxelIndex before = voxel;
    if (++next[axis] < size[axis]) f(voxel, axis, next);
    if (--before[axis] >= 0) f(before, axis, before);
  }
}

}  // namespace maille
