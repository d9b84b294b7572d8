// Which point of the volume at rest lies here now? The inverse of the cells' trilinear maps.
#pragma once

#include <optional>

#include "resample/claims.h"
#include "resample/deformed_cell.h"
#include "resample/sight.h"

namespace maille {

// Gives every open voxel of a brick its rest position, if the voxel lies in the deformed volume.
void find_rest(const Sight& sight, const VoxelBox& box, BrickClaims& claims);

// Rest position of any point of the deformed volume. nullopt: outside of it.
std::optional<glm::dvec3> rest_position_of(const DeformedVolume& volume, glm::dvec3 point_voxel);

// Whether a point (relative to origin) lies in one of the whole cells around an element.
bool covered_beside(const DeformedVolume& volume, VoxelIndex element, glm::ivec3 origin,
                    glm::vec3 point);

}  // namespace maille
