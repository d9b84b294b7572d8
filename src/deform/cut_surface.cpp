#include "deform/cut_surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "deform/polygon_triangles.h"

namespace maille {
namespace {

constexpr int kDiscCorners = 128;
// A corner may lie so far from the mean plane, as a share of the outline's extent.
constexpr double kFlatness = 0.1;

bool finite(glm::dvec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

Result<std::vector<CutPoint>> cut_points(std::span<const glm::dvec3> points_voxel) {
  std::vector<CutPoint> points;
  points.reserve(points_voxel.size());
  for (const glm::dvec3& p : points_voxel) {
    const glm::dvec3 size = glm::abs(p);
    // Written so that NaN fails.
    if (!(std::max({size.x, size.y, size.z}) <= double{kFurthestCut_voxels}) || !finite(p)) {
      return Error{ErrorKind::usage, "cut: expected point " + std::to_string(points.size()) +
                                         " to be finite and within " +
                                         std::to_string(kFurthestCut_voxels) +
                                         " voxels of the volume's first"};
    }
    points.emplace_back(std::llround(p.x * double{kCutUnitsPerVoxel}),
                        std::llround(p.y * double{kCutUnitsPerVoxel}),
                        std::llround(p.z * double{kCutUnitsPerVoxel}));
  }
  return points;
}

Result<void> check_flat(std::span<const CutPoint> corners) {
  const glm::dvec3 facing = facing_of(corners);
  const double area = glm::length(facing);
  if (area == 0.0) return {};  // triangulate() says so
  CutBounds bounds{corners[0], corners[0]};
  glm::dvec3 center(0.0);
  for (const CutPoint& p : corners) {
    bounds = {glm::min(bounds.lo, p), glm::max(bounds.hi, p)};
    center += glm::dvec3(p - corners[0]) / static_cast<double>(corners.size());
  }
  const double extent = glm::length(glm::dvec3(bounds.hi - bounds.lo));
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec3 offset = glm::dvec3(corners[i] - corners[0]) - center;
    if (std::abs(glm::dot(offset, facing / area)) > kFlatness * extent) {
      return Error{ErrorKind::usage, "cut: expected a flat polygon, but corner " +
                                         std::to_string(i) + " lies far from its mean plane"};
    }
  }
  return {};
}

// Halves the arc from corner `first` to `last` and each half again: long slivers would reach into
// many more bricks than they cut.
void fill_arc(std::span<const CutPoint> corners, std::size_t first, std::size_t last,
              std::vector<CutTriangle>& triangles) {
  if (last - first < 2) return;
  const std::size_t middle = (first + last) / 2;
  triangles.emplace_back(corners[first], corners[middle], corners[last % corners.size()]);
  fill_arc(corners, first, middle, triangles);
  fill_arc(corners, middle, last, triangles);
}

}  // namespace

Result<CutSurface> CutSurface::of(std::vector<CutTriangle> triangles) {
  // A triangle without area is covered by what lies beside it.
  std::erase_if(triangles, [](const CutTriangle& t) { return !t.has_area(); });
  if (triangles.empty()) return Error{ErrorKind::usage, "cut: the surface has no area"};
  CutSurface surface;
  surface.bounds_ = triangles.front().bounds();
  for (const CutTriangle& t : triangles) {
    surface.bounds_ = {glm::min(surface.bounds_.lo, t.bounds().lo),
                       glm::max(surface.bounds_.hi, t.bounds().hi)};
  }
  surface.triangles_ = std::move(triangles);
  return surface;
}

Result<CutSurface> CutSurface::disc(glm::dvec3 center_voxel, glm::dvec3 normal, double radius_mm,
                                    glm::dvec3 spacing_mm) {
  const double length = glm::length(normal);
  if (!finite(normal) || !std::isfinite(length) || !(length > 0.0)) {
    return Error{ErrorKind::usage, "cut: expected a disc's normal other than 0"};
  }
  if (!(radius_mm > 0.0) || !std::isfinite(radius_mm)) {
    return Error{ErrorKind::usage, "cut: expected a disc's radius above 0"};
  }
  if (!(std::min({spacing_mm.x, spacing_mm.y, spacing_mm.z}) > 0.0)) {
    return Error{ErrorKind::usage, "cut: expected a spacing above 0"};
  }
  const glm::dvec3 across = normal / length;
  const glm::dvec3 size = glm::abs(across);
  const glm::dvec3 other = size.x <= size.y && size.x <= size.z ? glm::dvec3(1, 0, 0)
                           : size.y <= size.z                   ? glm::dvec3(0, 1, 0)
                                                                : glm::dvec3(0, 0, 1);
  const glm::dvec3 right = glm::normalize(glm::cross(other, across));
  const glm::dvec3 up = glm::cross(across, right);
  std::vector<glm::dvec3> outline;
  for (int i = 0; i < kDiscCorners; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kDiscCorners;
    outline.push_back(center_voxel +
                      radius_mm * (std::cos(angle) * right + std::sin(angle) * up) / spacing_mm);
  }
  const Result<std::vector<CutPoint>> corners = cut_points(outline);
  if (!corners) return corners.error();
  std::vector<CutTriangle> triangles;
  fill_arc(*corners, 0, kDiscCorners, triangles);
  return of(std::move(triangles));
}

Result<CutSurface> CutSurface::polygon(std::span<const glm::dvec3> corners_voxel) {
  const Result<std::vector<CutPoint>> corners = cut_points(corners_voxel);
  if (!corners) return corners.error();
  if (corners->size() >= 3) {
    if (Result<void> flat = check_flat(*corners); !flat) return flat.error();
  }
  const Result<std::vector<std::array<int, 3>>> shape = triangulate(*corners);
  if (!shape) return shape.error();
  std::vector<CutTriangle> triangles;
  for (const auto& [a, b, c] : *shape) {
    triangles.emplace_back((*corners)[static_cast<std::size_t>(a)],
                           (*corners)[static_cast<std::size_t>(b)],
                           (*corners)[static_cast<std::size_t>(c)]);
  }
  return of(std::move(triangles));
}

Result<CutSurface> CutSurface::sweep(std::span<const glm::dvec3> path_voxel,
                                     glm::dvec3 depth_voxels) {
  if (path_voxel.size() < 2) {
    return Error{ErrorKind::usage, "cut: expected a path of at least 2 points"};
  }
  std::vector<glm::dvec3> deep_voxel(path_voxel.begin(), path_voxel.end());
  for (glm::dvec3& p : deep_voxel) p += depth_voxels;
  const Result<std::vector<CutPoint>> path = cut_points(path_voxel);
  if (!path) return path.error();
  const Result<std::vector<CutPoint>> deep = cut_points(deep_voxel);
  if (!deep) return deep.error();
  std::vector<CutTriangle> triangles;
  for (std::size_t i = 0; i + 1 < path->size(); ++i) {
    triangles.emplace_back((*path)[i], (*path)[i + 1], (*deep)[i + 1]);
    triangles.emplace_back((*path)[i], (*deep)[i + 1], (*deep)[i]);
  }
  return of(std::move(triangles));
}

}  // namespace maille
