// The inverse map by plain fixed-point iteration on x = X + u(X):
//
//     X_0 = x,   X_n+1 = x - u(X_n),   u trilinear between elements.
//
// Each iteration shrinks the error by |grad u| or better. Where that is 1 and more, as in material
// stretched to twice its length, it need not converge at all, and nothing in the answer tells:
// forward_voxels() of it does. It knows neither borders nor folds; beyond the border elements u is
// theirs. From the point itself and not from a neighbour's answer, so that what a number of
// iterations buys does not depend on the order of voxels.
#pragma once

#include <span>

#include "references/deformed_elements.h"

namespace maille {

// Trilinear between the values of elements; outside of them that of the border.
double trilinear(Size3 size, std::span<const double> values, glm::dvec3 rest_voxels);

// Where a point of the rest volume lies now: X + u(X).
glm::dvec3 forward_voxels(const DeformedElements& elements, glm::dvec3 rest_voxels);

// X after a number of iterations, at least 1.
glm::dvec3 rest_by_fixed_point(const DeformedElements& elements, glm::dvec3 point_voxels,
                               int iterations);

}  // namespace maille
