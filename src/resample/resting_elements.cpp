#include "resample/resting_elements.h"

namespace maille {

RestingElements::RestingElements(const DeformedVolume& volume, const VoxelBox& voxels)
    : voxels_(voxels), inside_(intersection(voxels, {VoxelIndex(0), volume.size()})) {
  if (inside_.empty()) return;
  brick_ = volume.moved_at(inside_.lo);
  cuts_ = volume.cuts_at(inside_.lo);
}

std::uint32_t RestingElements::row(int y, int z) const {
  if (inside_.empty() || y < inside_.lo.y || y >= inside_.hi.y || z < inside_.lo.z ||
      z >= inside_.hi.z) {
    return 0;
  }
  constexpr std::uint64_t kAll = ~std::uint32_t{0};
  const int first = inside_.lo.x & 31;  // in its brick
  const auto rests_in_volume = static_cast<std::uint32_t>(kAll >> (32 - inside_.size().x));
  const int element = element_in_brick({inside_.lo.x, y, z}) - first;
  std::uint32_t moved = 0;
  const bool row_moved = brick_ && y >= brick_->moved().lo.y && y < brick_->moved().hi.y &&
                         z >= brick_->moved().lo.z && z < brick_->moved().hi.z;
  if (row_moved) {
    std::int32_t u[3][kBrickEdge];
    for (int c = 0; c < 3; ++c) brick_->read_row(c, element, kBrickEdge, u[c]);
    for (int x = 0; x < kBrickEdge; ++x) {
      moved |= std::uint32_t{(u[0][x] | u[1][x] | u[2][x]) != 0} << x;
    }
  }
  if (cuts_) moved |= cuts_->carved[static_cast<std::size_t>(element / kBrickEdge)];
  return (~(moved >> first) & rests_in_volume) << (inside_.lo.x - voxels_.lo.x);
}

}  // namespace maille
