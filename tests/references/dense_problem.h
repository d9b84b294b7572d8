// A drag as the references see it: every element of a small volume in plain arrays, x fastest, one
// description for all of them, so that they and the product can be given the very same work.
//
// They share no code with the product but the definition of a material: limits are mixed and
// rounded here again (link_bounds.h), by other means than MaterialTable's.
#pragma once

#include <cstdint>
#include <vector>

#include "core/spaces.h"
#include "material/material_table.h"

namespace maille {

struct DenseProblem {
  Size3 size{0};
  std::vector<Material> materials;  // by id
  std::vector<MaterialId> ids;      // of each element
  std::vector<glm::ivec3> start;    // displacement of each element, 1/512 voxel
  std::vector<VoxelIndex> handle;   // elements that move as one
  std::vector<VoxelIndex> held;     // elements that never move, besides those of fixed materials
  // Bit a of an element: its link to the next one along axis a is gone. Empty: none is.
  std::vector<std::uint8_t> removed;
  glm::ivec3 by{0};  // of the handle, 1/512 voxel
};

struct DenseAnswer {
  std::vector<glm::ivec3> u;  // displacement of each element
  glm::ivec3 moved_by{0};     // of the handle
};

inline std::size_t element_of(VoxelIndex voxel, Size3 size) {
  return static_cast<std::size_t>(linear_index(voxel, size));
}

inline VoxelIndex voxel_of(std::size_t element, Size3 size) {
  const auto x = static_cast<std::size_t>(size.x);
  const auto y = static_cast<std::size_t>(size.y);
  return {static_cast<int>(element % x), static_cast<int>(element / x % y),
          static_cast<int>(element / x / y)};
}

// Calls f(neighbour, axis, side) for the up to six elements beside one; side is -1 or 1.
template <class F>
void for_each_neighbour(std::size_t element, Size3 size, F&& f) {
  const VoxelIndex voxel = voxel_of(element, size);
  std::size_t step = 1;
  for (int axis = 0; axis < 3; ++axis) {
    if (voxel[axis] > 0) f(element - step, axis, -1);
    if (voxel[axis] + 1 < size[axis]) f(element + step, axis, 1);
    step *= static_cast<std::size_t>(size[axis]);
  }
}

// Whether the link between an element and its neighbour on a side of it along an axis is gone.
inline bool link_removed(const DenseProblem& problem, std::size_t element, std::size_t neighbour,
                         int axis, int side) {
  if (problem.removed.empty()) return false;
  return (problem.removed[side > 0 ? element : neighbour] >> axis) & 1;
}

// One flag an element: of a fixed material, or held.
std::vector<std::uint8_t> immovable(const DenseProblem& problem);

}  // namespace maille
