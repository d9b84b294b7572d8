#include "resample/deformed_cell.h"

#include <algorithm>
#include <cmath>

namespace maille {
namespace {

constexpr int kNewtonSteps = 10;
constexpr float kSettled = 1e-5f;         // of a cell
constexpr float kSmallestVolume = 1e-6f;  // of a cell, in voxels

glm::vec3 xyz(Float4 v) { return {v[0], v[1], v[2]}; }

float excess(glm::vec3 t) {
  const glm::vec3 outside = glm::max(-t, t - 1.0f);
  return std::max(std::max(outside.x, outside.y), outside.z);
}

}  // namespace

CellInverse::CellInverse(const DeformedCell& cell, CellMap map) : cell_(cell), newton_(false) {
  if (map == CellMap::tetrahedra) return;
  const auto& c = cell.corner;
  constant_ = c[0];
  x_ = c[1] - c[0];
  y_ = c[2] - c[0];
  z_ = c[4] - c[0];
  xy_ = c[3] - c[2] - x_;
  xz_ = c[5] - c[4] - x_;
  yz_ = c[6] - c[4] - y_;
  xyz_ = c[7] - c[6] - (c[5] - c[4]) - xy_;
  const Float4 half = splat(0.5f);
  const Float4 quarter = splat(0.25f);
  const Float4 jx = x_ + half * (xy_ + xz_) + quarter * xyz_;
  const Float4 jy = y_ + half * (xy_ + yz_) + quarter * xyz_;
  const Float4 jz = z_ + half * (xz_ + yz_) + quarter * xyz_;
  center_ =
      xyz(constant_ + half * (x_ + y_ + z_) + quarter * (xy_ + xz_ + yz_) + splat(0.125f) * xyz_);
  const glm::mat3 x_from_t(xyz(jx), xyz(jy), xyz(jz));
  newton_ = glm::determinant(x_from_t) > kSmallestVolume;
  if (!newton_) return;
  t_from_x_ = glm::inverse(x_from_t);
  // With s = t - 1/2 the rest of the map is xy sx sy + xz sx sz + yz sy sz + xyz sx sy sz (its
  // mixed terms gathered in the middle); |s| <= 1 covers the cell and every margin asked for.
  const auto size = [](Float4 v) { return v > 0.0f ? v : -v; };
  const Float4 mixed = size(xy_) + size(xz_) + size(yz_) + splat(2.5f) * size(xyz_);
  const glm::mat3 absolute(glm::abs(t_from_x_[0]), glm::abs(t_from_x_[1]), glm::abs(t_from_x_[2]));
  const glm::vec3 strayed = absolute * xyz(mixed);
  bend_ = std::max({strayed.x, strayed.y, strayed.z});
}

std::optional<glm::vec3> CellInverse::operator()(glm::vec3 point, float margin) const {
  if (newton_) {
    bool settled = false;
    const auto t = by_newton(point, margin, settled);
    if (settled) return t;
  }
  return by_tetrahedra(point, margin);
}

// settled: no answer is one too.
std::optional<glm::vec3> CellInverse::by_newton(glm::vec3 point, float margin,
                                                bool& settled) const {
  glm::vec3 t = t_from_x_ * (point - center_) + 0.5f;
  settled = true;
  if (excess(t) > margin + bend_) return std::nullopt;
  if (bend_ < kSettled) return t;
  for (int step = 0; step < kNewtonSteps; ++step) {
    t = glm::clamp(t, glm::vec3(-1.0f), glm::vec3(2.0f));
    const Float4 tx = splat(t.x), ty = splat(t.y), tz = splat(t.z);
    const Float4 at = constant_ + tx * (x_ + ty * xy_) + ty * (y_ + tz * yz_) +
                      tz * (z_ + tx * (xz_ + ty * xyz_));
    const glm::vec3 residual = point - xyz(at);
    const Float4 jx = x_ + ty * xy_ + tz * (xz_ + ty * xyz_);
    const Float4 jy = y_ + tx * xy_ + tz * (yz_ + tx * xyz_);
    const Float4 jz = z_ + tx * xz_ + ty * (yz_ + tx * xyz_);
    // The Jacobian in the middle serves while the residual is small enough for it.
    glm::vec3 correction = t_from_x_ * residual;
    const glm::vec3 size = glm::abs(correction);
    if (std::max({size.x, size.y, size.z}) > 0.02f) {
      const glm::mat3 x_from_t(xyz(jx), xyz(jy), xyz(jz));
      const float volume = glm::determinant(x_from_t);
      if (!(volume > kSmallestVolume)) break;
      correction = glm::inverse(x_from_t) * residual;
    }
    t += correction;
    const glm::vec3 moved = glm::abs(correction);
    if (std::max({moved.x, moved.y, moved.z}) < kSettled) {
      if (excess(t) > margin) return std::nullopt;
      return t;
    }
  }
  settled = false;
  return std::nullopt;
}

std::optional<glm::vec3> CellInverse::by_tetrahedra(glm::vec3 point, float margin) const {
  // Each a path of edges from corner 0 to corner 7.
  constexpr std::array<std::array<int, 3>, 6> kPaths = {
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  std::optional<glm::vec3> best;
  float best_excess = std::max(margin, kSettled);
  for (const auto& path : kPaths) {
    const int first = 1 << path[0];
    const int second = first | 1 << path[1];
    const glm::vec3 origin = xyz(cell_.corner[0]);
    const glm::vec3 a = xyz(cell_.corner[static_cast<std::size_t>(first)]) - origin;
    const glm::vec3 b = xyz(cell_.corner[static_cast<std::size_t>(second)] -
                            cell_.corner[static_cast<std::size_t>(first)]);
    const glm::vec3 c = xyz(cell_.corner[7] - cell_.corner[static_cast<std::size_t>(second)]);
    const glm::mat3 edges(a, b, c);
    const float volume = glm::determinant(edges);
    if (std::abs(volume) < 1e-12f) continue;
    const glm::vec3 s = glm::inverse(edges) * (point - origin);  // 1 >= s0 >= s1 >= s2 >= 0 inside
    const float outside = std::max({s[0] - 1.0f, s[1] - s[0], s[2] - s[1], -s[2]});
    if (outside > best_excess) continue;
    best_excess = outside;
    glm::vec3 t;
    for (int i = 0; i < 3; ++i) t[path[static_cast<std::size_t>(i)]] = s[i];
    best = t;
  }
  return best;
}

bool DeformedCell::folded() const {
  for (std::size_t i = 0; i < 8; ++i) {
    const glm::vec3 here = xyz(corner[i]);
    const auto edge = [&](std::size_t bit) {
      const glm::vec3 along = xyz(corner[i ^ bit]) - here;
      return i & bit ? -along : along;
    };
    if (glm::determinant(glm::mat3(edge(1), edge(2), edge(4))) <= 0.0f) return true;
  }
  return false;
}

}  // namespace maille
