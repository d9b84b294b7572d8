// Which point of the volume at rest lies here now, in a cell with removed links?
#pragma once

#include <optional>

#include "resample/claims.h"
#include "resample/deformed_cell.h"
#include "resample/sight.h"

namespace maille {

// Gives open voxels of a box the rest positions that octants of moved cut cells claim, and notes
// the voxels that a cut may have left with nothing.
void claim_cut_voxels(const Sight& sight, const VoxelBox& box, BrickClaims& claims, ClaimPass pass);

// The best claim of a cut cell's octants to a point. Positions are relative to origin.
std::optional<Claim> cut_claim(const DeformedVolume& volume, const DeformedCell& cell,
                               VoxelIndex base, glm::ivec3 origin, glm::vec3 point);

}  // namespace maille
