// What is wrong with an answer, told from its displacements alone: the same checks for every order
// of work, by code that knows none of them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

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
// Which they are: a flag an element, of the cell above it. Corners that a cut goes through (removed
// as in DenseProblem; empty: none) fold nothing.
std::vector<std::uint8_t> dense_folds(Size3 size, std::span<const glm::ivec3> u,
                                      std::span<const std::uint8_t> removed);

}  // namespace maille
