// Displacement fields for saving: vectors in mm along the world's axes (LPS).
#pragma once

#include <vector>

#include "core/parallel.h"
#include "deform/lattice.h"
#include "resample/resampler.h"
#include "volume/volume.h"

namespace maille {

// A vector for every voxel of a box of the deformed volume that leads to where its value came from:
// x_in = x_out + field(x_out). 0 where nothing is.
std::vector<glm::vec3> inverse_field_mm(const Resampler& resampler, const VoxelBox& extent,
                                        WorkerPool& pool);

// The displacement of every element, on the rest grid: x_now = x_rest + field(x_rest).
std::vector<glm::vec3> forward_field_mm(const Volume& volume, const Lattice& lattice,
                                        WorkerPool& pool);

}  // namespace maille
