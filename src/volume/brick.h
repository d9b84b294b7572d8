// A volume cut into bricks of 32^3 voxels: the unit that is touched, resampled and uploaded.
#pragma once

#include <cstdint>

#include "core/spaces.h"

namespace maille {

inline constexpr int kBrickEdge = 32;
inline constexpr int kBrickVoxels = kBrickEdge * kBrickEdge * kBrickEdge;

using BrickIndex = glm::ivec3;

// Half-open box of voxels: lo inside, hi outside.
struct VoxelBox {
  VoxelIndex lo{0};
  VoxelIndex hi{0};

  Size3 size() const { return hi - lo; }
  bool empty() const { return hi.x <= lo.x || hi.y <= lo.y || hi.z <= lo.z; }
  bool operator==(const VoxelBox&) const = default;
};

inline VoxelBox intersection(const VoxelBox& a, const VoxelBox& b) {
  return {glm::max(a.lo, b.lo), glm::min(a.hi, b.hi)};
}
// The smallest box around both; empty ones do not count.
inline VoxelBox united(const VoxelBox& a, const VoxelBox& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {glm::min(a.lo, b.lo), glm::max(a.hi, b.hi)};
}

inline VoxelBox shifted(const VoxelBox& box, glm::ivec3 by) { return {box.lo + by, box.hi + by}; }

class BrickGrid {
 public:
  BrickGrid() = default;
  explicit BrickGrid(Size3 volume_size)
      : volume_size_(volume_size), bricks_((volume_size + (kBrickEdge - 1)) / kBrickEdge) {}

  Size3 volume_size() const { return volume_size_; }
  Size3 bricks() const { return bricks_; }
  std::int64_t count() const { return voxel_count(bricks_); }
  bool contains(BrickIndex brick) const { return maille::contains(bricks_, brick); }
  std::int64_t linear(BrickIndex brick) const { return linear_index(brick, bricks_); }
  BrickIndex brick(std::int64_t linear) const {
    const auto row = linear / bricks_.x;
    return {static_cast<int>(linear % bricks_.x), static_cast<int>(row % bricks_.y),
            static_cast<int>(row / bricks_.y)};
  }

  // The brick's voxels that lie in the volume: border bricks may hold fewer than 32 along an axis.
  VoxelBox box(BrickIndex brick) const {
    const VoxelIndex lo = brick * kBrickEdge;
    return {lo, glm::min(lo + kBrickEdge, volume_size_)};
  }

  static BrickIndex brick_of(VoxelIndex voxel) {
    return {voxel.x >> 5, voxel.y >> 5, voxel.z >> 5};  // floor, for negative indices too
  }

 private:
  Size3 volume_size_{0};
  Size3 bricks_{0};
};

}  // namespace maille
