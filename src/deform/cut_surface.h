// What a cutting stroke sweeps: a surface of triangles.
//
// A person cuts what they see, so it lies in deformed voxel space: an element is at X + u(X).
// Corners are rounded to 1/65536 voxel; callers convert from mm with the volume's transform.
#pragma once

#include <span>
#include <vector>

#include "core/result.h"
#include "deform/cut_triangle.h"

namespace maille {

class CutSurface {
 public:
  // Errors of all three: usage (a coordinate that is not finite or beyond 2^23 voxels; a surface
  // without area).

  // Flat and round in mm: the normal is given in mm along the volume's own axes, the centre in
  // voxels. Its outline is a regular polygon of 128 corners, which is within radius_mm / 3000 of
  // the circle. Errors also: usage (radius not above 0, no normal, no spacing above 0).
  static Result<CutSurface> disc(glm::dvec3 center_voxel, glm::dvec3 normal, double radius_mm,
                                 glm::dvec3 spacing_mm);

  // Inside of a closed outline, convex or not, in order either way round. Errors also: usage (fewer
  // than 3 different corners, edges that touch or cross, a corner further than a tenth of the
  // outline's extent from its mean plane).
  static Result<CutSurface> polygon(std::span<const glm::dvec3> corners_voxel);

  // A blade whose edge reaches from the path to path + depth, dragged along the path. May cross
  // itself. Errors also: usage (fewer than 2 points).
  static Result<CutSurface> sweep(std::span<const glm::dvec3> path_voxel, glm::dvec3 depth_voxels);

  // None without area.
  std::span<const CutTriangle> triangles() const { return triangles_; }
  const CutBounds& bounds() const { return bounds_; }

 private:
  static Result<CutSurface> of(std::vector<CutTriangle> triangles);

  std::vector<CutTriangle> triangles_;
  CutBounds bounds_;
};

}  // namespace maille
