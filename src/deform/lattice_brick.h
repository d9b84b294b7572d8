// The displacements of the 32^3 elements of a brick, in which something has moved. Immutable.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "deform/displacement_plane.h"

namespace maille {

inline int element_in_brick(VoxelIndex voxel) {
  return ((voxel.z & 31) * kBrickEdge + (voxel.y & 31)) * kBrickEdge + (voxel.x & 31);
}

// u of all elements, written out: what a solver works on before a brick is made of it.
struct BrickDisplacements {
  std::int32_t u[3][kBrickVoxels] = {};  // [component][element]
};

class LatticeBrick {
 public:
  using Pointer = std::shared_ptr<const LatticeBrick>;
  using Planes = std::array<DisplacementPlane::Pointer, 3>;

  // box: the brick's voxels that lie in the volume. Null where everything rests.
  static Pointer create(const VoxelBox& box, const BrickDisplacements& displacements);
  static Pointer create(Planes planes);

  // Null: the component is 0 everywhere. Planes are shared with the bricks made from this one.
  const DisplacementPlane::Pointer& plane(int component) const {
    return planes_[static_cast<std::size_t>(component)];
  }

  glm::ivec3 u(int element) const {
    glm::ivec3 value(0);
    for (int c = 0; c < 3; ++c) {
      if (plane(c)) value[c] = plane(c)->at(element);
    }
    return value;
  }
  // So many values of a component in a row, from an element on.
  void read_row(int component, int first, int count, std::int32_t* u) const;

  // Least and greatest u over the elements in the volume, and the box of those with u != 0 (voxels
  // of the volume).
  const glm::ivec3& lowest() const { return lowest_; }
  const glm::ivec3& highest() const { return highest_; }
  const VoxelBox& moved() const { return moved_; }

  std::int64_t bytes() const;

 private:
  Planes planes_;
  glm::ivec3 lowest_{0};
  glm::ivec3 highest_{0};
  VoxelBox moved_;
};

// Whether two bricks (null: at rest) hold the same displacements for the elements of a box.
bool same_displacements(const LatticeBrick* a, const LatticeBrick* b, const VoxelBox& box);

}  // namespace maille
