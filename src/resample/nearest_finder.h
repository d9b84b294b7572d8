// Which element lies nearest to a voxel now?
#pragma once

#include "resample/claims.h"
#include "resample/sight.h"

namespace maille {

// Gives every open voxel of a brick the element that lies nearest (in mm, ties to the lower index)
// if the voxel lies in the deformed volume.
//
// Each element offers itself to the voxels around it. How far it must: a point of a cell is the
// mean of the cell's corners, weighted by the trilinear map's own weights, and the variance of a
// mean within bounds of width r is at most r^2/4 along each axis; so some corner lies within half
// the diagonal of the cell's bounds, folded or not.
//
// Distance knows no sides of a cut: in cut cells the octant that holds a voxel decides, with its
// own element, and where neither an octant nor a whole cell holds the voxel nothing does.
void find_nearest(const Sight& sight, const VoxelBox& box, BrickClaims& claims);

}  // namespace maille
