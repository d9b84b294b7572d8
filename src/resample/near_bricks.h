// Which bricks' voxels may have one of some elements as the nearest to them, or as a neighbour of
// that: cells hold voxels that other elements are nearer to, where they are long or sheared.
//
// A point is no further from some corner of a cell that holds it than half the diagonal of the
// cell's bounds; so what is nearest to it is not either.
#pragma once

#include <vector>

#include "deform/lattice.h"
#include "resample/brick_set.h"

namespace maille {

class NearBricks {
 public:
  // extent: the voxels that are shown, which bricks are counted of.
  NearBricks(const Lattice& lattice, glm::dvec3 spacing_mm, const VoxelBox& extent);

  // Of elements that lie in a box.
  void add(const VoxelBox& voxels, BrickSet& to) const;

 private:
  VoxelBox extent_;
  BrickGrid grid_;
  glm::ivec3 furthest_voxels_;
  std::vector<glm::ivec3> around_voxels_;  // how far from the voxels of a brick, along each axis
};

}  // namespace maille
