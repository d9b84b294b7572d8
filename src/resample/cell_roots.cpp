#include "resample/cell_roots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace maille {
namespace {

constexpr float kSettled = 2e-6f;  // of the cell
constexpr int kSteps = 40;
// Beyond these a flat cell's line of answers is long enough.
constexpr int kMostParts = 2000;
constexpr std::size_t kMostRoots = 16;

// An eighth of an eighth ... of the cell.
struct Part {
  DeformedCell shape;
  glm::vec3 first;  // t of its lowest corner
  float edge;
};

glm::vec3 xyz(Float4 v) { return {v[0], v[1], v[2]}; }

Float4 at(const DeformedCell& cell, glm::vec3 t) {
  const auto& c = cell.corner;
  const auto mix = [](Float4 a, Float4 b, float s) { return a + splat(s) * (b - a); };
  const Float4 near = mix(mix(c[0], c[1], t.x), mix(c[2], c[3], t.x), t.y);
  const Float4 far = mix(mix(c[4], c[5], t.x), mix(c[6], c[7], t.x), t.y);
  return mix(near, far, t.z);
}

// d x / d t.
glm::mat3 slope(const DeformedCell& cell, glm::vec3 t) {
  const auto& c = cell.corner;
  const auto mix = [](Float4 a, Float4 b, float s) { return a + splat(s) * (b - a); };
  const Float4 x = mix(mix(c[1] - c[0], c[3] - c[2], t.y), mix(c[5] - c[4], c[7] - c[6], t.y), t.z);
  const Float4 y = mix(mix(c[2] - c[0], c[3] - c[1], t.x), mix(c[6] - c[4], c[7] - c[5], t.x), t.z);
  const Float4 z = mix(mix(c[4] - c[0], c[5] - c[1], t.x), mix(c[6] - c[2], c[7] - c[3], t.x), t.y);
  return {xyz(x), xyz(y), xyz(z)};
}

// No edge is further than this from what it is in the middle, after the inverse of that: no two
// points of the part lie on one another then.
constexpr float kStraight = 0.45f;

bool nearly_straight(const DeformedCell& shape, const glm::mat3& middle) {
  constexpr float kFlat = 1e-12f;
  const float volume = glm::determinant(middle);
  if (!(std::abs(volume) > kFlat)) return false;
  const glm::mat3 inverse = glm::inverse(middle);
  float away[3] = {0, 0, 0};
  const auto& c = shape.corner;
  constexpr std::size_t kSides[3][4] = {{0, 2, 4, 6}, {0, 1, 4, 5}, {0, 1, 2, 3}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    float most[3] = {0, 0, 0};
    for (const std::size_t from : kSides[axis]) {
      const glm::vec3 edge = xyz(c[from + (std::size_t{1} << axis)] - c[from]);
      const glm::vec3 off = inverse * (edge - middle[static_cast<int>(axis)]);
      for (int i = 0; i < 3; ++i) most[i] = std::max(most[i], std::abs(off[i]));
    }
    for (int i = 0; i < 3; ++i) away[i] += most[i];
  }
  return std::max({away[0], away[1], away[2]}) < kStraight;
}

// With the slope in the middle of a part that is nearly straight: what is left of the way to an
// answer in it shrinks by kStraight and what is beyond the part each time. nullopt: there is none.
std::optional<glm::vec3> by_contraction(const DeformedCell& cell, glm::vec3 point,
                                        glm::vec3 middle) {
  const glm::mat3 t_from_x = glm::inverse(slope(cell, middle));
  glm::vec3 t = middle;
  for (int step = 0; step < kSteps; ++step) {
    const glm::vec3 correction = t_from_x * (point - xyz(at(cell, t)));
    t += correction;
    const glm::vec3 size = glm::abs(correction);
    const float longest = std::max({size.x, size.y, size.z});
    if (longest < kSettled) break;
    if (!(longest < 2.0f)) return std::nullopt;
  }
  return t;
}

// 3 x 3 x 3 points: the corners of the eighths.
using Points = std::array<Float4, 27>;

Points points_of(const DeformedCell& shape) {
  Points points;
  const Float4 half = splat(0.5f);
  for (std::size_t k = 0; k < 8; ++k) {
    points[(k >> 2) * 18 + (k >> 1 & 1) * 6 + (k & 1) * 2] = shape.corner[k];
  }
  for (const std::size_t i : {1, 7, 19, 25}) points[i] = half * (points[i - 1] + points[i + 1]);
  for (const std::size_t i : {3, 4, 5, 21, 22, 23}) {
    points[i] = half * (points[i - 3] + points[i + 3]);
  }
  for (std::size_t i = 9; i < 18; ++i) points[i] = half * (points[i - 9] + points[i + 9]);
  return points;
}

DeformedCell eighth(const Points& points, std::size_t part) {
  const std::size_t first = (part >> 2) * 9 + (part >> 1 & 1) * 3 + (part & 1);
  return {{points[first], points[first + 1], points[first + 3], points[first + 4],
           points[first + 9], points[first + 10], points[first + 12], points[first + 13]}};
}

// Whether the bounds of its corners hold a point. slack: how far outside of it counts, as a share
// of its edge.
bool may_hold(const DeformedCell& shape, Float4 point, float slack) {
  Float4 lowest = shape.corner[0];
  Float4 highest = shape.corner[0];
  for (const Float4& corner : shape.corner) {
    lowest = least(lowest, corner);
    highest = greatest(highest, corner);
  }
  constexpr float kRounding = 1e-6f;
  const Float4 extent = highest - lowest;
  const Float4 allowed = extent * splat(slack + kRounding) + splat(kRounding);
  const auto outside = (point < lowest - allowed) | (point > highest + allowed);
  return (outside[0] | outside[1] | outside[2]) == 0;
}

float largest_extent(const DeformedCell& shape) {
  float largest = 0.0f;
  for (const Float4& corner : shape.corner) {
    const glm::vec3 away = glm::abs(xyz(corner - shape.corner[0]));
    largest = std::max({largest, away.x, away.y, away.z});
  }
  return largest;
}

}  // namespace

const std::vector<glm::vec3>& cell_roots(const DeformedCell& cell, glm::vec3 point, float margin) {
  static thread_local std::vector<glm::vec3> roots;
  static thread_local std::vector<Part> open;
  roots.clear();
  open.clear();
  const Float4 at_point{point.x, point.y, point.z, 0.0f};
  const float near = near_enough(largest_extent(cell), margin);
  if (may_hold(cell, at_point, margin)) open.push_back({cell, glm::vec3(0.0f), 1.0f});
  for (int left = kMostParts; left > 0 && !open.empty() && roots.size() < kMostRoots; --left) {
    const Part part = open.back();
    open.pop_back();
    const float half = 0.5f * part.edge;
    const glm::vec3 middle = part.first + half;
    if (nearly_straight(part.shape, slope(part.shape, glm::vec3(0.5f)))) {
      auto t = by_contraction(cell, point, middle);
      if (!t) continue;
      // Where the cell is nearly flat rounding may lead far beyond the part, and yet be near.
      t = glm::clamp(*t, middle - half - margin, middle + half + margin);
      const glm::vec3 off = glm::abs(point - xyz(at(cell, *t)));
      if (std::max({off.x, off.y, off.z}) < near) roots.push_back(*t);
      continue;
    }
    if (largest_extent(part.shape) < kOnAPoint_voxels) {
      roots.push_back(middle);
      continue;
    }
    const Points points = points_of(part.shape);
    for (std::size_t k = 8; k-- > 0;) {
      const DeformedCell shape = eighth(points, k);
      if (!may_hold(shape, at_point, margin / half)) continue;
      const glm::vec3 corner(k & 1, k >> 1 & 1, k >> 2);
      open.push_back({shape, part.first + half * corner, half});
    }
  }
  return roots;
}

}  // namespace maille
