// What value a voxel shows once the walk of paper_walk.h has found it an element: the paper's three
// ways, in double precision.
#pragma once

#include <span>

#include "references/deformed_elements.h"

namespace maille {

enum class PaperMethod {
  nearest,  // the element's own
  // Linear in a tetrahedron that holds the point: each cell around the element is the six along its
  // diagonal from corner (0,0,0) to (1,1,1). All six, not only those that have the element for a
  // corner: where cells are sheared the nearest element need not belong to the one that holds the
  // point. Where several hold it (folds) it is the first, by index of the cell.
  barycentric,
  // The mean of the element and its 26 neighbours, weighted by exp(-(d / 1.4 voxels)^2): the paper
  // says "radius" and not of what, and this is what a Gaussian's shape parameter means. Whatever
  // lies beyond the 26 has no weight, so that the value jumps where the element found changes.
  rbf
};

inline constexpr double kRbfRadius_voxels = 1.4;

struct PaperValue {
  double value;
  // Of barycentric, where no tetrahedron holds the point, which then gets the element's own value:
  // in the outer half of a border element, in a volume of a single layer, and where the walk ended
  // beside an element whose cells lie elsewhere.
  bool interpolated;
};

// values: of each element. element: what the walk found for the point.
PaperValue paper_value(const DeformedElements& elements, std::span<const double> values,
                       std::size_t element, glm::dvec3 point_voxels, PaperMethod method);

}  // namespace maille
