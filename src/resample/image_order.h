// Values of voxels that are known to have one answer each (rest_march.h), row by row.
#pragma once

#include "resample/resample_counts.h"
#include "resample/resampling.h"
#include "resample/sight.h"

namespace maille {

// False where that is not known; nothing has been written and counted then. voxels: in
// sight and in the target.
bool resample_in_image_order(const Resampling& resampling, const Sight& sight,
                             const VoxelBox& voxels, const VoxelTarget& target,
                             ResampleCounts& counts);

}  // namespace maille
