#include "volume/volume.h"

namespace maille {

std::size_t bytes_per_voxel(VoxelType type) {
  return with_voxel_type(type, []<class T>() { return sizeof(T); });
}

std::string_view name_of(VoxelType type) {
  switch (type) {
    case VoxelType::uint8: return "uint8";
    case VoxelType::int8: return "int8";
    case VoxelType::uint16: return "uint16";
    case VoxelType::int16: return "int16";
    case VoxelType::float32: break;
  }
  return "float32";
}

Volume::Volume(Size3 size, VoxelType type, const glm::dmat4& world_from_voxel,
               std::span<const std::byte> voxels, std::shared_ptr<const void> owner)
    : size_(size),
      type_(type),
      world_from_voxel_(world_from_voxel),
      voxels_(voxels),
      owner_(std::move(owner)) {}

glm::dvec3 Volume::spacing_mm() const {
  return {glm::length(glm::dvec3(world_from_voxel_[0])),
          glm::length(glm::dvec3(world_from_voxel_[1])),
          glm::length(glm::dvec3(world_from_voxel_[2]))};
}

double Volume::value_at(VoxelIndex voxel) const {
  const auto index = static_cast<std::size_t>(linear_index(voxel, size_));
  return with_voxel_type(type_, [&]<class T>() { return static_cast<double>(voxels<T>()[index]); });
}

glm::dmat4 axis_aligned(glm::dvec3 spacing_mm, glm::dvec3 origin_mm) {
  glm::dmat4 world_from_voxel(1.0);
  for (int axis = 0; axis < 3; ++axis) world_from_voxel[axis][axis] = spacing_mm[axis];
  world_from_voxel[3] = glm::dvec4(origin_mm, 1.0);
  return world_from_voxel;
}

}  // namespace maille
