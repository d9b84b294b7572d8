// Values of voxels that are known to have one answer each (rest_march.h), row by row.
#pragma once

#include "resample/resample_counts.h"
#include "resample/resampling.h"
#include "resample/sight.h"

namespace maille {

// Boxes are tried in parts down to this edge.
inline constexpr int kSmallestPart = 8;

// False where that is not known, or a part of the voxels would do better; nothing has been written
// and counted then. voxels: in sight and in the target.
bool resample_in_image_order(const Resampling& resampling, const Sight& sight,
                             const VoxelBox& voxels, const VoxelTarget& target,
                             ResampleCounts& counts);

}  // namespace maille
