// What is wrong with an answer, told from its displacements alone: the same checks for every order
// of work, by code that knows none of them.
#pragma once

#include <cstdint>
#include <span>

#include "references/dense_problem.h"

namespace maille {

struct DenseViolations {
  std::int64_t links = 0;   // whose two elements are outside their limits in some component
  double worst_voxels = 0;  // beyond the limit
};
DenseViolations dense_violations(const DenseProblem& problem, std::span<const glm::ivec3> u);

// Cells between eight neighbouring elements whose trilinear map turns inside out (or goes flat) at
// a corner.
std::int64_t dense_folded_cells(Size3 size, std::span<const glm::ivec3> u);
std::int64_t dense_folded_cells(Size3 size, std::span<const glm::dvec3> u_voxels);

}  // namespace maille
