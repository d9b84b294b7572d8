// The spaces that positions live in. A transform is named target_from_source, so that a wrong
// product looks wrong: p_world = world_from_voxel * p_voxel.
//
//   voxel   continuous index space; sample (i,j,k) sits at its integer point, x fastest   [voxels]
//   world   patient or specimen space, LPS as in ITK                                      [mm]
//   brick   32^3 voxels; brick b covers voxels 32b .. 32b+31 (volume/brick.h)             [bricks]
//   pixel   (0,0) is the top left corner of the picture, a pixel's centre is at +0.5      [pixels]
#pragma once

#include <cstdint>

#include <glm/glm.hpp>

namespace maille {

using Size3 = glm::ivec3;       // extent along x, y, z, in voxels (or bricks, where a name says so)
using VoxelIndex = glm::ivec3;  // a sample's index; signed, so that neighbours of 0 can be named

inline std::int64_t voxel_count(Size3 size) { return std::int64_t{size.x} * size.y * size.z; }

// Position of a sample in memory, x fastest. 64 bits: volumes pass 2^31 samples.
inline std::int64_t linear_index(VoxelIndex voxel, Size3 size) {
  return (std::int64_t{voxel.z} * size.y + voxel.y) * size.x + voxel.x;
}
inline VoxelIndex voxel_index(std::int64_t linear, Size3 size) {
  return {static_cast<int>(linear % size.x), static_cast<int>(linear / size.x % size.y),
          static_cast<int>(linear / size.x / size.y)};
}

inline bool contains(Size3 size, VoxelIndex voxel) {
  return voxel.x >= 0 && voxel.y >= 0 && voxel.z >= 0 && voxel.x < size.x && voxel.y < size.y &&
         voxel.z < size.z;
}

inline glm::dvec3 transform_point(const glm::dmat4& target_from_source, glm::dvec3 point) {
  return glm::dvec3(target_from_source * glm::dvec4(point, 1.0));
}

inline glm::dvec3 transform_vector(const glm::dmat4& target_from_source, glm::dvec3 vector) {
  return glm::dvec3(target_from_source * glm::dvec4(vector, 0.0));
}

}  // namespace maille
