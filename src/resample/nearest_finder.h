// Which element lies nearest to a voxel now?
#pragma once

#include "resample/claims.h"
#include "resample/sight.h"

namespace maille {

// Gives every open voxel that a cell holds the element that lies nearest of all (in mm, ties to the
// lower index).
//
// Which voxels those are cells tell (rest_finder.h), and with it how far the nearest element is at
// most: that far around the voxels every element offers itself. An element at rest among others at
// rest need not, for one of those is nearer to any voxel that is not its own.
//
// Distance knows no sides of a cut: in cut cells the octant that holds a voxel decides, with its
// own element.
void find_nearest(const Sight& sight, const VoxelBox& box, BrickClaims& claims);

}  // namespace maille
