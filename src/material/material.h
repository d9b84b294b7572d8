// One material, as a person gives it: how far its links may go, how its springs pull and when they
// give in.
//
// Limits are fractions of the voxel spacing (Gibson 1997; the paper, section 4).
#pragma once

#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "core/result.h"

namespace maille {

struct Material {
  std::string name;
  double value_low = 0.0;  // half-open range [low, high) of voxel values, in the file's own units
  double value_high = 0.0;
  glm::dvec3 compress{0.6};  // shortest link along each axis, 0 <= compress <= 1
  glm::dvec3 stretch{1.5};   // longest link along each axis, >= 1
  glm::dvec3 shear{0.25};    // how far each component may slip across a link of another axis, >= 0
  double stiffness = 1.0;    // of its springs, > 0; only ratios matter
  bool fixed = false;        // an anchor: never moves
  bool rigid = false;        // its links keep their length and direction: compress = stretch = 1,
                             // shear = 0, whatever stands above
  // The share of its springs, 0 to 1, that keeps the rest vector and not only the rest length: the
  // more, the further it can be compressed before it buckles, and the more it minds being turned.
  // None: the table chooses (default_blend.h).
  std::optional<double> rest_vector_blend{};
  // Strain of a spring (change of its length over its rest length, > 0) up to which it springs back
  // fully; what goes beyond stays when the handle is released (deform/yield_flow.h). Below some
  // 0.01 the rounding of positions counts too. None: it never yields.
  std::optional<double> yield_strain{};
};

// bad_input naming the material and what was expected: a limit outside its range, a stiffness
// outside 1e-12 to 1e12, a blend outside 0 to 1, a yield strain not above 0, an empty value range.
// None where all is well.
std::optional<Error> refusal_of(const Material& material);

// What is expected of limits, where these are none; for materials and for what makes materials.
std::optional<std::string> expectation_of_limits(const glm::dvec3& compress,
                                                 const glm::dvec3& stretch,
                                                 const glm::dvec3& shear);

// The first component whose limits allow a folded cell; none: no state within the limits has one.
// Row c of a cell's Jacobian has at least compress[c] on the diagonal and at most shear[c] twice
// beside it, so compress > 2 shear in every row makes it diagonally dominant; a row without shear
// needs nothing of its diagonal.
std::optional<int> component_that_may_fold(const glm::dvec3& compress, const glm::dvec3& shear);

}  // namespace maille
