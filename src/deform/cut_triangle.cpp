#include "deform/cut_triangle.h"

#include <algorithm>
#include <cmath>

namespace maille {

ExactVector exact_cross(CutPoint a, CutPoint b) {
  return {Int128{a.y} * b.z - Int128{a.z} * b.y, Int128{a.z} * b.x - Int128{a.x} * b.z,
          Int128{a.x} * b.y - Int128{a.y} * b.x};
}

Int128 exact_dot(const ExactVector& a, CutPoint b) { return a[0] * b.x + a[1] * b.y + a[2] * b.z; }

CutTriangle::CutTriangle(CutPoint a, CutPoint b, CutPoint c)
    : corners_{a, b, c},
      normal_(exact_cross(b - a, c - a)),
      bounds_{glm::min(glm::min(a, b), c), glm::max(glm::max(a, b), c)} {
  // Of normal . (p - a - shift) only the shift is left on the plane.
  const auto first =
      std::find_if(normal_.begin(), normal_.end(), [](const Int128& n) { return n != 0; });
  above_on_plane_ = first != normal_.end() && *first < 0;
}

bool CutTriangle::has_area() const { return normal_ != ExactVector{}; }

bool CutTriangle::above(CutPoint p) const {
  const Int128 height = exact_dot(normal_, p - corners_[0]);
  return height == 0 ? above_on_plane_ : height > 0;
}

bool CutTriangle::pierced_by(CutPoint p, CutPoint q) const {
  const CutPoint along = q - p;
  bool turns_left = false;
  bool turns_right = false;
  for (std::size_t k = 0; k < 3; ++k) {
    const CutPoint edge = corners_[(k + 1) % 3] - corners_[k];
    const Int128 turn = exact_dot(exact_cross(edge, along), corners_[k] - p);
    turns_left = turns_left || turn > 0;
    turns_right = turns_right || turn < 0;
  }
  return !(turns_left && turns_right);
}

// Separating axes: the triangle's normal and the nine products of its edges with the box's. Doubles
// will do, with a margin far above their rounding.
bool CutTriangle::may_touch(const CutBounds& box) const {
  for (int c = 0; c < 3; ++c) {
    if (box.hi[c] < bounds_.lo[c] || box.lo[c] > bounds_.hi[c]) return false;
  }
  const glm::dvec3 half = 0.5 * (glm::dvec3(box.hi) - glm::dvec3(box.lo));
  const glm::dvec3 center = 0.5 * (glm::dvec3(box.hi) + glm::dvec3(box.lo));
  std::array<glm::dvec3, 3> corners;
  double furthest = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    corners[k] = glm::dvec3(corners_[k]) - center;
    furthest = std::max(furthest, glm::length(corners[k]));
  }
  const auto separates = [&](glm::dvec3 axis) {
    const double a = glm::dot(axis, corners[0]);
    const double b = glm::dot(axis, corners[1]);
    const double c = glm::dot(axis, corners[2]);
    const double reach =
        glm::dot(glm::abs(axis), half) + 1e-12 * furthest * glm::length(axis) + 1e-300;
    return std::min({a, b, c}) > reach || std::max({a, b, c}) < -reach;
  };
  const std::array<glm::dvec3, 3> edges = {corners[1] - corners[0], corners[2] - corners[1],
                                           corners[0] - corners[2]};
  if (separates(glm::cross(edges[0], edges[1]))) return false;
  for (const glm::dvec3& edge : edges) {
    if (separates({0.0, edge.z, -edge.y})) return false;
    if (separates({-edge.z, 0.0, edge.x})) return false;
    if (separates({edge.y, -edge.x, 0.0})) return false;
  }
  return true;
}

}  // namespace maille
