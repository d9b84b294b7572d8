// A polygon cut into triangles.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/result.h"
#include "deform/cut_triangle.h"

namespace maille {

// Corners of the triangles, as indices. The polygon need not be convex nor quite planar; all its
// edges are edges of triangles, and the triangles meet in whole edges, so that nothing slips
// through. Ears are clipped in the projection along the axis that the polygon faces most, by exact
// determinants (Meisters 1975: a simple polygon always has an ear). Errors: usage (fewer than 3
// different corners, edges that touch or cross in the projection, no area).
Result<std::vector<std::array<int, 3>>> triangulate(std::span<const CutPoint> corners);

// Twice the area as a vector across the polygon (Newell), in cut units squared.
glm::dvec3 facing_of(std::span<const CutPoint> corners);

}  // namespace maille
