// Some of a grid's bricks.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "volume/brick.h"

namespace maille {

// Calls f(brick) for all bricks that hold one of the voxels, by rising index.
template <class F>
void for_each_brick_over(const VoxelBox& voxels, F&& f) {
  if (voxels.empty()) return;
  const BrickIndex lo = BrickGrid::brick_of(voxels.lo);
  const BrickIndex hi = BrickGrid::brick_of(voxels.hi - 1);
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x) f(BrickIndex(x, y, z));
    }
  }
}

class BrickSet {
 public:
  explicit BrickSet(const BrickGrid& grid)
      : grid_(grid), words_(static_cast<std::size_t>((grid.count() + 63) / 64)) {}

  void add(std::int64_t brick) {
    words_[static_cast<std::size_t>(brick >> 6)] |= std::uint64_t{1} << (brick & 63);
  }
  // All bricks that hold one of the voxels (a box in the volume, or empty).
  void add_over(const VoxelBox& voxels) {
    for_each_brick_over(voxels, [&](BrickIndex brick) { add(grid_.linear(brick)); });
  }
  bool contains(std::int64_t brick) const {
    return ((words_[static_cast<std::size_t>(brick >> 6)] >> (brick & 63)) & 1) != 0;
  }

  // By rising index.
  std::vector<std::int64_t> list() const {
    std::vector<std::int64_t> bricks;
    for (std::size_t w = 0; w < words_.size(); ++w) {
      for (std::uint64_t left = words_[w]; left != 0; left &= left - 1) {
        bricks.push_back(static_cast<std::int64_t>(w * 64) + std::countr_zero(left));
      }
    }
    return bricks;
  }

 private:
  BrickGrid grid_;
  std::vector<std::uint64_t> words_;  // a bit a brick: few even beside an empty brick table
};

}  // namespace maille
