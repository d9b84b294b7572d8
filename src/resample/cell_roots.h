// All points of a cell that lie at one point now, the cell folded or not.
//
// By subdivision: the map of an eighth of a cell is trilinear again, and lies within the bounds of
// its corners; where those hold the point it is cut on, until it is so nearly straight that
// Newton's method finds the one answer in it. Where the cell is flat there may be a line of
// answers: some of it are found.
#pragma once

#include <vector>

#include "resample/deformed_cell.h"

namespace maille {

// What floats and their inverses may leave between an answer and the point, or a margin of cells of
// that extent.
inline constexpr float kOnAPoint_voxels = 2e-4f;
inline float near_enough(float extent_voxels, float margin) {
  return kOnAPoint_voxels + 0.5f * margin * extent_voxels;
}

// The t in [0,1]^3, or up to `margin` outside of it, whose x(t) is the point, x trilinear; by
// rising position of the eighths that hold them. An answer between eighths may be there twice. The
// list is kept by thread, until the next one is asked for.
const std::vector<glm::vec3>& cell_roots(const DeformedCell& cell, glm::vec3 point, float margin);

}  // namespace maille
