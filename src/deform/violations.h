// Links whose two elements are outside their limits, counted over the bricks that hold elements and
// the ones beside them; a removed link is none. Knows nothing of how the lattice was made.
#pragma once

#include <cstdint>

#include "deform/cuts.h"
#include "deform/lattice.h"
#include "material/material_field.h"

namespace maille {

struct Violations {
  std::int64_t links = 0;
  double worst_voxels = 0.0;
};

Violations violations_of(const Lattice& lattice, const MaterialField& materials, const Cuts& cuts);

}  // namespace maille
