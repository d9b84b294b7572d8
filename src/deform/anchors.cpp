#include "deform/anchors.h"

#include <cmath>

namespace maille {

void ElementSet::insert(VoxelIndex voxel, const BrickGrid& grid) {
  auto& mask = masks_[grid.linear(BrickGrid::brick_of(voxel))];
  if (!mask) mask = std::make_unique<Mask>();
  mask->set(static_cast<std::size_t>(element_in_brick(voxel)));
}

bool ElementSet::contains(VoxelIndex voxel, const BrickGrid& grid) const {
  const Mask* mask = brick(grid.linear(BrickGrid::brick_of(voxel)));
  return mask && mask->test(static_cast<std::size_t>(element_in_brick(voxel)));
}

const ElementSet::Mask* ElementSet::brick(std::int64_t linear) const {
  const auto found = masks_.find(linear);
  return found == masks_.end() ? nullptr : found->second.get();
}

bool ElementSet::intersects(const ElementSet& other) const {
  for (const auto& [linear, mask] : masks_) {
    const Mask* theirs = other.brick(linear);
    if (theirs && (*mask & *theirs).any()) return true;
  }
  return false;
}

void ElementSet::insert(const ElementSet& other) {
  for (const auto& [linear, theirs] : other.masks_) {
    auto& mask = masks_[linear];
    if (!mask) mask = std::make_unique<Mask>();
    *mask |= *theirs;
  }
}

ElementSet& ElementSet::operator=(const ElementSet& other) {
  if (this == &other) return *this;
  masks_.clear();
  insert(other);
  return *this;
}

ElementSet ball_of_elements(VoxelIndex center, double radius_voxels, const BrickGrid& grid) {
  ElementSet ball;
  const double reach = std::min(std::floor(radius_voxels), 1e6);
  const auto r = static_cast<int>(reach);
  const VoxelIndex lo = glm::max(center - r, VoxelIndex(0));
  const VoxelIndex hi = glm::min(center + r, grid.volume_size() - 1);
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x) {
        const glm::dvec3 offset = glm::dvec3(x, y, z) - glm::dvec3(center);
        if (glm::dot(offset, offset) <= radius_voxels * radius_voxels) {
          ball.insert({x, y, z}, grid);
        }
      }
    }
  }
  return ball;
}

std::uint8_t faces_of(VoxelIndex voxel, Size3 size) {
  std::uint8_t faces = 0;
  if (voxel.x == 0) faces |= face_low_x;
  if (voxel.y == 0) faces |= face_low_y;
  if (voxel.z == 0) faces |= face_low_z;
  if (voxel.x == size.x - 1) faces |= face_high_x;
  if (voxel.y == size.y - 1) faces |= face_high_y;
  if (voxel.z == size.z - 1) faces |= face_high_z;
  return faces;
}

}  // namespace maille
