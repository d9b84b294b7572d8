// Which point of the volume at rest lies here now? The inverse of the cells' maps.
#pragma once

#include <optional>

#include "resample/claims.h"
#include "resample/deformed_cell.h"
#include "resample/sight.h"

namespace maille {

// Gives every open voxel of a box its rest position, if the voxel lies in the deformed volume.
void find_rest(const Sight& sight, const VoxelBox& box, BrickClaims& claims);

// Rest position of any point of the deformed volume. nullopt: outside of it.
std::optional<glm::dvec3> rest_position_of(const DeformedVolume& volume, glm::dvec3 point_voxel);

}  // namespace maille
