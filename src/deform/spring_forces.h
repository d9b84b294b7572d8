// The springs of one element and what they pull with: the inner loop of relaxation.
#pragma once

#include <array>
#include <cstdint>

#include "core/spaces.h"
#include "volume/brick.h"

namespace maille {

// A brick and one element around it, as arrays of 34^3, x fastest.
inline constexpr int kSpringHaloEdge = kBrickEdge + 2;
inline constexpr int halo_index(int x, int y, int z) {  // of an element of the brick itself
  return ((z + 1) * kSpringHaloEdge + y + 1) * kSpringHaloEdge + x + 1;
}

struct Spring {
  glm::ivec3 offset{0};  // from element i to element j
  int halo_step = 0;     // the same in a halo array
  glm::vec3 rest_mm{0};  // X_i - X_j
  float length_mm = 0.0f;
};

// To the 6 axis neighbours and the 12 face diagonals.
using Springs = std::array<Spring, 18>;
Springs springs_of(glm::dvec3 spacing_mm);

// Halo arrays from the first element of a row on. Compliance is 1 / stiffness, infinite where there
// is no element.
struct HaloRow {
  const float* u_x_mm;
  const float* u_y_mm;
  const float* u_z_mm;
  const float* compliance;
};

struct RowForces {
  float x[kBrickEdge];
  float y[kBrickEdge];
  float z[kBrickEdge];
};

// Forces (stiffness * mm) on the 32 elements of a row. Compiled for several vector widths, chosen
// when the program is loaded; every operation is rounded alike in all of them, so are the results.
void add_up_forces(const HaloRow& row, const Springs& springs, float rest_vector_blend,
                   RowForces& forces);

// The same without the springs that are missing: a bit a spring, for each element of the row.
// Apart, so that rows without cuts pay nothing for it.
void add_up_forces_left(const HaloRow& row, const Springs& springs, float rest_vector_blend,
                        const std::uint32_t* missing, RowForces& forces);

}  // namespace maille
