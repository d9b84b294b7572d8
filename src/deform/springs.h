// The springs of an element: to its 6 axis neighbours and across its 12 face diagonals, all equally
// stiff, which makes them isotropic (Poisson's ratio 1/4) and leaves no mode without energy.
//
// With X at rest, x = X + u in mm, r = X_i - X_j, d = |r|, p = x_i - x_j and l = |p| a spring has
//
//     E = (1 - b) k (l - d)^2 / 2 + b k |p - r|^2 / 2        (stiffness * mm^2)
//
// The first part is the paper's eq. (4), its sign and scale mended; the second minds direction too,
// which keeps compressed cells from buckling (b: the materials' rest_vector_blend, their mean). k
// is that of both materials in series. No stretch makes the Hessian more than k times the identity:
// what any step and the multigrid rely on.
//
// Material that has yielded (yield_flow.h) rests elsewhere: at X + P, P being the displacements
// that it has kept. Its springs have the rest vector r' = r + P_i - P_j and the rest length |r'| in
// place of r and d; x, and what counts as folded, are as before. P is 0 nearly everywhere, and
// where it is no loop knows of it. Keeping a rest length a spring is the road not taken: 18 numbers
// an element that need not fit together, so that a block that has yielded would strain itself for
// ever.
#pragma once

#include <array>

#include "core/spaces.h"

namespace maille {

struct Spring {
  glm::ivec3 offset{0};  // from element i to element j
  glm::vec3 rest_mm{0};  // X_i - X_j
  float length_mm = 0.0f;
};

// Springs 2 s and 2 s + 1 are opposite ones: the even ones of all elements are all springs, once.
inline constexpr int kSprings = 18;
using Springs = std::array<Spring, kSprings>;
Springs springs_of(glm::dvec3 spacing_mm);

}  // namespace maille
