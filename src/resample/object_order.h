// Values of voxels that cells have to look for (rest_finder.h, nearest_finder.h): beside cuts,
// folds and wherever there is very much more material than voxels.
#pragma once

#include "resample/resample_counts.h"
#include "resample/resampling.h"
#include "resample/sight.h"

namespace maille {

// voxels: in sight and in the target.
void resample_in_object_order(const Resampling& resampling, const Sight& sight,
                              const VoxelBox& voxels, const VoxelTarget& target,
                              ResampleCounts& counts);

}  // namespace maille
