// What a region's held rim carries: whether the region is large enough.
#pragma once

#include <vector>

#include "deform/spring_box.h"

namespace maille {

// Forces (stiffness * mm) of the box's free elements on the rim's, face by face; only faces beyond
// which the volume goes on and could move. whole: the voxels of the volume that may move.
std::vector<glm::dvec3> rim_forces(const SpringBox& box, const VoxelBox& whole);

// About how far the rim would go if it could, in voxels, for what its forces have become since the
// region was begun: what an element alone would go, times the elements between here and where
// something holds (a displacement falls off like one over the distance).
double rim_pull_voxels(const SpringBox& box, const VoxelBox& whole,
                       const std::vector<glm::dvec3>& before);

}  // namespace maille
