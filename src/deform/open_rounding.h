// Rounds a state to fixed point without folding a cell.
//
// Fixed point knows a displacement to 1/512 voxel: where a pull has pressed cells flat, or drawn
// edges long, the nearest such displacement may fold what is open. Then an element there takes one
// of the next nearest.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "deform/fold_energy.h"

namespace maille {

struct OpenRounding {
  // Displacements in mm, in fixed point, of the elements that must not take the nearest, rising.
  std::vector<std::pair<std::int64_t, glm::dvec3>> elsewhere;
  // All corners that rounding may fold, by rising element.
  std::vector<CellCorner> at_risk;
};

// Corners that no choice within a unit opens are left folded. Throws std::bad_alloc.
OpenRounding open_rounding(const SpringBox& box, WorkerPool& pool);

}  // namespace maille
