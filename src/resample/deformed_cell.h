// A cell of the lattice as it lies now: eight corners and the map between them, t in [0,1]^3:
//
//     x(t) = sum over corners of N(t) x_corner,
//
// with N trilinear in the cell, or linear in each of its tetrahedra.
#pragma once

#include <array>

#include "core/spaces.h"

namespace maille {

// x, y, z and one lane to spare; four floats wide because every step of the map is done on all
// three components at once.
using Float4 = float __attribute__((vector_size(16)));

inline Float4 splat(float value) { return Float4{value, value, value, value}; }
inline Float4 least(Float4 a, Float4 b) { return a < b ? a : b; }
inline Float4 greatest(Float4 a, Float4 b) { return a > b ? a : b; }

// What lies between a cell's corners.
enum class CellMap {
  trilinear,
  tetrahedra,  // linear in each of the six around the diagonal from the lowest corner (Kuhn's)
};

struct DeformedCell {
  // Corner (i,j,k) at i + 2j + 4k. Positions in voxel space, relative to whatever origin keeps the
  // numbers small; the fourth lane is above 0 where the element moved.
  std::array<Float4, 8> corner;

  // Whether the map turns inside out at a corner.
  bool folded() const;
};

}  // namespace maille
