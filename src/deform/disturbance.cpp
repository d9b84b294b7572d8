#include "deform/disturbance.h"

namespace maille {

VoxelBox moved_box(const Lattice& lattice) {
  VoxelBox box;
  lattice.for_each_brick(
      [&](std::int64_t, const LatticeBrick& brick) { box = united(box, brick.moved()); });
  return box;
}

VoxelBox difference_box(const Lattice& before, const Lattice& now) {
  VoxelBox box;
  Lattice::for_each_difference(before, now, [&](std::int64_t linear) {
    for (const Lattice* lattice : {&before, &now}) {
      if (const LatticeBrick* brick = lattice->brick(linear)) box = united(box, brick->moved());
    }
  });
  return box;
}

VoxelBox difference_box(const Cuts& before, const Cuts& now, const Lattice& lattice) {
  VoxelBox cut;
  Cuts::for_each_difference(before, now, [&](std::int64_t linear) {
    // A link reaches one element beyond the brick that it belongs to, a diagonal before it too.
    const VoxelBox brick = now.grid().box(now.grid().brick(linear));
    cut = united(cut, {brick.lo - 1, brick.hi + 1});
  });
  const VoxelBox moved = moved_box(lattice);
  if (moved.empty()) return {};
  const VoxelBox both = intersection(cut, {moved.lo - 1, moved.hi + 1});
  return intersection(both, {VoxelIndex(0), lattice.grid().volume_size()});
}

VoxelBox box_of(const ElementSet& set, const BrickGrid& grid) {
  VoxelBox box;
  for (const auto& [linear, mask] : set.bricks()) {
    const VoxelIndex origin = grid.brick(linear) * kBrickEdge;
    for (int e = 0; e < kBrickVoxels; ++e) {
      if (!mask->test(static_cast<std::size_t>(e))) continue;
      const VoxelIndex at = origin + VoxelIndex(e & 31, (e >> 5) & 31, e >> 10);
      box = united(box, {at, at + 1});
    }
  }
  return box;
}

}  // namespace maille
