// Where a deformation may be away from the equilibrium of its springs: what relaxation looks at.
//
// Travels with the state it is of, so that undo brings back what was known of the state it brings
// back. Boxes are of bricks' moved elements: larger than what a step disturbed, never smaller.
#pragma once

#include "deform/anchors.h"
#include "deform/cuts.h"
#include "deform/lattice.h"

namespace maille {

struct Disturbance {
  VoxelBox box;  // empty: none
  // Outside the box the state came this near to equilibrium, the last time it was relaxed.
  double elsewhere_voxels = 0.0;
};

// Of the elements that are not at rest.
VoxelBox moved_box(const Lattice& lattice);
// Of all elements that lie elsewhere in one than in the other.
VoxelBox difference_box(const Lattice& before, const Lattice& now);
// Of the elements whose springs are others, as far as these can pull: springs at rest do not.
VoxelBox difference_box(const Cuts& before, const Cuts& now, const Lattice& lattice);
VoxelBox box_of(const ElementSet& set, const BrickGrid& grid);

}  // namespace maille
