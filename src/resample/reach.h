// Where the moved elements of a lattice brick have got to: which cells they shape and which voxels
// those cells can cover.
#pragma once

#include <cstdint>
#include <vector>

#include "deform/cuts.h"
#include "deform/lattice.h"
#include "resample/resample_method.h"

namespace maille {

// A cell is named by its corner of lowest index, `base`: it lies between the elements base and
// base + 1. Base -1 and base n-1 are the half cells by which the volume reaches beyond its border.
struct Reach {
  VoxelBox cells;          // bases of the cells that have a moved corner in the brick
  glm::ivec3 u_lowest{0};  // fixed-point bounds of u over all their corners
  glm::ivec3 u_highest{0};

  // Voxels that the cells can cover, whether the volume has them or not.
  VoxelBox covered() const;
};

// The brick must hold elements.
Reach reach_of(const Lattice& lattice, std::int64_t brick);

// The bricks whose voxels may differ between two states of a lattice and its cuts, in linear order.
// extent: the voxels that are shown, which bricks are counted of.
std::vector<std::int64_t> dirty_bricks(const Lattice& before, const Cuts& cuts_before,
                                       const Lattice& after, const Cuts& cuts_after,
                                       glm::dvec3 spacing_mm, const VoxelBox& extent,
                                       ResampleMethod method);

}  // namespace maille
