// A triangle of a cut, and which links it severs, in exact integer arithmetic.
//
// A cut must part its two sides completely: one link that survives by rounding holds a whole volume
// together. So corners and elements are integers of 1/65536 voxel (an element's place is a multiple
// of 1/512 anyway) and the determinants that decide are computed in 128 bits, without error.
//
// Ties are decided as if the surface stood an infinitesimal step (e, e^2, e^3) further along x, y
// and z: an element exactly on it belongs to the side of the lower x (then y, then z). One shift
// for all triangles is enough: a segment with its ends on two sides of a triangle's plane is not
// parallel to it. What is cut is what a real surface in general position cuts, so no path of links
// that are left leads through it, whatever edges, corners or elements coincide. (The full
// perturbation of Edelsbrunner and Muecke, one a corner, says no more and costs a dozen more
// determinants.) On top of that a link that meets the very edge of a triangle is cut, so that a
// polygon drawn to the volume's border cuts the links in the border too.
#pragma once

#include <array>
#include <cstdint>

#include "core/spaces.h"

namespace maille {

inline constexpr std::int64_t kCutUnitsPerVoxel = 65536;
using CutPoint = glm::vec<3, std::int64_t>;  // voxel space, in 1/65536 voxel

// Coordinates as far from 0 as this keep every determinant below 2^124.
inline constexpr std::int64_t kFurthestCut_voxels = std::int64_t{1} << 23;

__extension__ using Int128 = __int128;
using ExactVector = std::array<Int128, 3>;

// a x b and a . b without rounding, for differences of cut points.
ExactVector exact_cross(CutPoint a, CutPoint b);
Int128 exact_dot(const ExactVector& a, CutPoint b);

// Closed on both ends.
struct CutBounds {
  CutPoint lo{0};
  CutPoint hi{0};
};

class CutTriangle {
 public:
  CutTriangle(CutPoint a, CutPoint b, CutPoint c);

  const std::array<CutPoint, 3>& corners() const { return corners_; }
  const CutBounds& bounds() const { return bounds_; }
  bool has_area() const;

  // The side of the triangle's plane that a point lies on, never neither.
  bool above(CutPoint p) const;
  // For points on different sides: whether the segment between them meets the triangle.
  bool pierced_by(CutPoint p, CutPoint q) const;

  // False only if no point of the box lies in the triangle; seldom true then.
  bool may_touch(const CutBounds& box) const;

 private:
  std::array<CutPoint, 3> corners_;
  ExactVector normal_;
  bool above_on_plane_ = false;
  CutBounds bounds_;
};

}  // namespace maille
