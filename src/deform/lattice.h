// The lattice: the displacement u of every element (voxel), x = X + u.
//
// Displacements are fixed-point integers of 1/512 voxel, so that sums are exact and any order of
// work gives the same bits. Bricks are made only where something moved; an absent brick is at rest
// (u = 0). Bricks are shared between copies of a lattice, so the state at button-down, undo steps
// and what a reader on another thread looks at are plain copies that keep only what differs.
#pragma once

#include <cstdint>

#include "deform/lattice_brick.h"
#include "material/material_table.h"
#include "volume/brick_table.h"

namespace maille {

class Lattice : public BrickTable<LatticeBrick> {
 public:
  using BrickTable::BrickTable;

  glm::ivec3 u(VoxelIndex voxel) const {  // fixed point; voxel must lie inside
    const LatticeBrick* b = brick(grid().linear(BrickGrid::brick_of(voxel)));
    return b ? b->u(element_in_brick(voxel)) : glm::ivec3(0);
  }
  glm::dvec3 displacement_voxels(VoxelIndex voxel) const {
    return glm::dvec3(u(voxel)) / double{kUnitsPerVoxel};
  }

  std::int64_t brick_count() const;  // bricks that hold elements
  std::int64_t bytes() const;        // of these, also where other lattices share them
  // Of their displacements, in memory or put aside: the same whatever other threads have read.
  std::int64_t displacement_bytes() const;
  bool at_rest() const { return empty(); }
};

// Whether every element lies in the same place.
bool same_displacements(const Lattice& a, const Lattice& b);

}  // namespace maille
