#include "resample/cell_inverse.h"

#include <algorithm>
#include <cmath>

#include "resample/cell_roots.h"

namespace maille {
namespace {

constexpr int kNewtonSteps = 12;
constexpr float kSettled = 1e-5f;         // of a cell
constexpr float kSmallestVolume = 1e-6f;  // of a cell, in voxels

glm::vec3 xyz(Float4 v) { return {v[0], v[1], v[2]}; }

float excess(glm::vec3 t) {
  const glm::vec3 outside = glm::max(-t, t - 1.0f);
  return std::max(std::max(outside.x, outside.y), outside.z);
}

}  // namespace

CellInverse::CellInverse(const DeformedCell& cell, CellMap map) : cell_(cell), map_(map) {
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
  if (!(glm::determinant(x_from_t) > kSmallestVolume)) return;
  t_from_x_ = glm::inverse(x_from_t);
  // With s = t - 1/2 the rest of the map is xy sx sy + xz sx sz + yz sy sz + xyz sx sy sz (its
  // mixed terms gathered in the middle); |s| <= 1 covers the cell and every margin asked for.
  const auto size = [](Float4 v) { return v > 0.0f ? v : -v; };
  const Float4 mixed = size(xy_) + size(xz_) + size(yz_) + splat(2.5f) * size(xyz_);
  const glm::mat3 absolute(glm::abs(t_from_x_[0]), glm::abs(t_from_x_[1]), glm::abs(t_from_x_[2]));
  const glm::vec3 strayed = absolute * xyz(mixed);
  bend_ = std::max({strayed.x, strayed.y, strayed.z});
  // No edge is then so far from what it is in the middle that the cell could fold.
  constexpr float kNearlyStraight = 0.3f;
  nearly_straight_ = bend_ < kNearlyStraight;
}

glm::vec3 CellInverse::x_of(glm::vec3 t) const {
  const Float4 tx = splat(t.x), ty = splat(t.y), tz = splat(t.z);
  return xyz(constant_ + tx * (x_ + ty * xy_) + ty * (y_ + tz * yz_) +
             tz * (z_ + tx * (xz_ + ty * xyz_)));
}

std::optional<glm::vec3> CellInverse::by_newton(glm::vec3 point, float margin) const {
  // The Jacobian in the middle serves as far as the map is straighter still.
  constexpr float kStraight = 0.1f;
  glm::vec3 t = t_from_x_ * (point - center_) + 0.5f;
  if (excess(t) > margin + bend_) return std::nullopt;
  for (int step = 0; step < kNewtonSteps; ++step) {
    const glm::vec3 residual = point - x_of(t);
    glm::vec3 correction = t_from_x_ * residual;
    if (bend_ > kStraight) {
      const Float4 tx = splat(t.x), ty = splat(t.y), tz = splat(t.z);
      const Float4 jx = x_ + ty * xy_ + tz * (xz_ + ty * xyz_);
      const Float4 jy = y_ + tx * xy_ + tz * (yz_ + tx * xyz_);
      const Float4 jz = z_ + tx * xz_ + ty * (yz_ + tx * xyz_);
      correction = glm::inverse(glm::mat3(xyz(jx), xyz(jy), xyz(jz))) * residual;
    }
    t += correction;
    const glm::vec3 moved = glm::abs(correction);
    if (std::max({moved.x, moved.y, moved.z}) < kSettled) break;
  }
  if (excess(t) <= margin) return t;
  // In a cell that is squeezed flat so little is far beyond it.
  const glm::vec3 inside = glm::clamp(t, 0.0f, 1.0f);
  const glm::vec3 off = glm::abs(x_of(inside) - point);
  if (!(std::max({off.x, off.y, off.z}) < kOnAPoint_voxels)) return std::nullopt;
  return inside;
}

const std::vector<glm::vec3>& CellInverse::answers(glm::vec3 point, float margin) const {
  if (map_ == CellMap::trilinear) return cell_roots(cell_, point, margin);
  static thread_local std::vector<glm::vec3> in_tetrahedra;
  in_tetrahedra.clear();
  // Each a path of edges from corner 0 to corner 7.
  constexpr std::array<std::array<int, 3>, 6> kPaths = {
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
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
    if (!(outside <= std::max(margin, kSettled))) continue;
    glm::vec3 t;
    for (int i = 0; i < 3; ++i) t[path[static_cast<std::size_t>(i)]] = s[i];
    in_tetrahedra.push_back(t);
  }
  return in_tetrahedra;
}

}  // namespace maille
