// The demonstration: a head whose nose is pulled out and let settle.
#pragma once

#include "app/scene.h"
#include "volume/statistics.h"
#include "volume/volume.h"

namespace maille {

// The built-in head, as large as two cores without a GPU can play with.
Scene built_in_scene();

// The element at the tip of whatever sticks out farthest to the front (for a face: the nose).
// Front is -y of the world (anterior, LPS), along the volume's axis that is closest to it. Looked
// for in the middle: a third of the width, three fifths of the height, so that ears, shoulders and
// the table are passed by. A voxel counts when it and the ones behind it are at least
// surface_value, so that noise in the air does not. Where nothing counts, the volume's centre.
struct Protrusion {
  VoxelIndex tip{0};
  glm::ivec3 outward{0, -1, 0};  // one step along the volume's axis, away from the face
};
Protrusion most_anterior(const Volume& volume, double surface_value);

// Actions for a scene that has none, and a three-quarter camera unless it has one: the tip is
// dragged outwards by 25 voxels, but by no more than 8 % of the volume's extent and not out of it,
// in 25 steps, and the whole relaxed.
void add_demonstration(Scene& scene, const Volume& volume, const VolumeStatistics& range);

}  // namespace maille
