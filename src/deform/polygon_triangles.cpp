#include "deform/polygon_triangles.h"

#include <algorithm>
#include <numeric>
#include <string>

namespace maille {
namespace {

using Point2 = glm::vec<2, std::int64_t>;

// Above 0 where a, b, c turn left.
int turn(Point2 a, Point2 b, Point2 c) {
  const Int128 area = Int128{b.x - a.x} * (c.y - a.y) - Int128{b.y - a.y} * (c.x - a.x);
  return area > 0 ? 1 : area < 0 ? -1 : 0;
}

bool in_box(Point2 a, Point2 b, Point2 p) {
  return glm::all(glm::lessThanEqual(glm::min(a, b), p)) &&
         glm::all(glm::lessThanEqual(p, glm::max(a, b)));
}

// Whether two segments have a point in common.
bool meet(Point2 a, Point2 b, Point2 c, Point2 d) {
  const int abc = turn(a, b, c);
  const int abd = turn(a, b, d);
  const int cda = turn(c, d, a);
  const int cdb = turn(c, d, b);
  if (abc * abd < 0 && cda * cdb < 0) return true;
  return (abc == 0 && in_box(a, b, c)) || (abd == 0 && in_box(a, b, d)) ||
         (cda == 0 && in_box(c, d, a)) || (cdb == 0 && in_box(c, d, b));
}

// Seen along the axis it faces most, corners turning left.
std::vector<Point2> projected(std::span<const CutPoint> corners, glm::dvec3 facing) {
  const glm::dvec3 size = glm::abs(facing);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const int right = (axis + 1) % 3;
  const int up = (axis + 2) % 3;
  std::vector<Point2> seen;
  for (const CutPoint& p : corners) {
    seen.push_back(facing[axis] > 0 ? Point2(p[right], p[up]) : Point2(p[up], p[right]));
  }
  return seen;
}

// names: what a person calls the corners.
Result<void> check_simple(std::span<const Point2> points, std::span<const int> names) {
  const std::size_t n = points.size();
  const auto error = [&](std::size_t i, std::size_t j) {
    return Error{ErrorKind::usage, "cut: the edges of the polygon after corners " +
                                       std::to_string(names[i]) + " and " +
                                       std::to_string(names[j]) + " touch or cross"};
  };
  for (std::size_t i = 0; i < n; ++i) {
    const Point2 a = points[i];
    const Point2 b = points[(i + 1) % n];
    // The edge after this one begins at its end: it may go anywhere but back.
    const Point2 c = points[(i + 2) % n];
    if (turn(a, b, c) == 0 && (in_box(a, b, c) || in_box(b, c, a))) return error(i, (i + 1) % n);
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      if (meet(a, b, points[j], points[(j + 1) % n])) return error(i, j);
    }
  }
  return {};
}

class EarClipping {
 public:
  explicit EarClipping(std::span<const Point2> points) : points_(points), left_(points.size()) {
    std::iota(left_.begin(), left_.end(), 0);
  }

  std::vector<std::array<int, 3>> run() {
    std::vector<std::array<int, 3>> triangles;
    while (left_.size() > 3) {
      const std::size_t ear = next_ear();
      triangles.push_back(triangle(ear));
      left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    triangles.push_back({left_[0], left_[1], left_[2]});
    return triangles;
  }

 private:
  std::array<int, 3> triangle(std::size_t at) const {
    const std::size_t n = left_.size();
    return {left_[(at + n - 1) % n], left_[at], left_[(at + 1) % n]};
  }
  Point2 point(int corner) const { return points_[static_cast<std::size_t>(corner)]; }

  // Straight corners go first: then the diagonals that are left pass through none. Their triangle
  // has no area in the projection, but may have some where the polygon is not quite planar.
  std::size_t next_ear() const {
    for (std::size_t i = 0; i < left_.size(); ++i) {
      const auto [a, b, c] = triangle(i);
      if (turn(point(a), point(b), point(c)) == 0) return i;
    }
    for (std::size_t i = 0; i < left_.size(); ++i) {
      if (is_ear(triangle(i))) return i;
    }
    return 0;  // never: every simple polygon has an ear
  }

  bool is_ear(const std::array<int, 3>& corners) const {
    const auto [a, b, c] = corners;
    if (turn(point(a), point(b), point(c)) < 0) return false;
    return std::none_of(left_.begin(), left_.end(), [&](int other) {
      if (other == a || other == b || other == c) return false;
      const Point2 p = point(other);
      return turn(point(a), point(b), p) >= 0 && turn(point(b), point(c), p) >= 0 &&
             turn(point(c), point(a), p) >= 0;
    });
  }

  std::span<const Point2> points_;
  std::vector<int> left_;
};

}  // namespace

glm::dvec3 facing_of(std::span<const CutPoint> corners) {
  glm::dvec3 facing(0.0);
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    facing +=
        glm::cross(glm::dvec3(corners[i] - corners[0]), glm::dvec3(corners[i + 1] - corners[0]));
  }
  return facing;
}

Result<std::vector<std::array<int, 3>>> triangulate(std::span<const CutPoint> corners) {
  // A corner said twice in a row is one corner; a closed outline says its first one again.
  std::vector<int> different;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (different.empty() || corners[i] != corners[static_cast<std::size_t>(different.back())]) {
      different.push_back(static_cast<int>(i));
    }
  }
  while (different.size() > 1 && corners[static_cast<std::size_t>(different.back())] ==
                                     corners[static_cast<std::size_t>(different.front())]) {
    different.pop_back();
  }
  if (different.size() < 3) {
    return Error{ErrorKind::usage, "cut: expected a polygon of at least 3 different corners"};
  }
  std::vector<CutPoint> outline;
  for (const int i : different) outline.push_back(corners[static_cast<std::size_t>(i)]);
  const glm::dvec3 facing = facing_of(outline);
  if (facing == glm::dvec3(0.0)) {
    return Error{ErrorKind::usage, "cut: the polygon has no area"};
  }
  const std::vector<Point2> seen = projected(outline, facing);
  if (Result<void> simple = check_simple(seen, different); !simple) return simple.error();
  std::vector<std::array<int, 3>> triangles = EarClipping(seen).run();
  for (auto& triangle : triangles) {
    for (int& corner : triangle) corner = different[static_cast<std::size_t>(corner)];
  }
  return triangles;
}

}  // namespace maille
