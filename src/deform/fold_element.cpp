#include "deform/fold_element.h"

#include <algorithm>
#include <cmath>

namespace maille {
namespace {

glm::dvec3 at(const BoxVectors& v, std::int64_t e) {
  return {double{v[0][e]}, double{v[1][e]}, double{v[2][e]}};
}

}  // namespace

FoldElement::FoldElement(const FoldEnergy& folds, std::int64_t element) : element_(element) {
  const SpringBox& box = folds.box();
  const Size3 extent = box.extent();
  const std::int64_t row = element / extent.x;
  color_ = static_cast<int>(((element - row * extent.x) & 1) | (row % extent.y & 1) << 1 |
                            (row / extent.y & 1) << 2);
  for (int s = 0; s < kSprings; ++s) {
    const double k = double{box.stiffness(element, s)};
    if (!(k > 0.0)) continue;
    const Spring& spring = box.springs()[static_cast<std::size_t>(s)];
    const std::int64_t other = element + box.step(s);
    const glm::dvec3 kept_mm = box.kept_mm(element, s);
    const glm::dvec3 rest_mm = glm::dvec3(spring.rest_mm) + kept_mm;
    const double length_mm = box.keeps() ? glm::length(rest_mm) : double{spring.length_mm};
    springs_.push_back({other, rest_mm, kept_mm, length_mm, k,
                        0.5 * (double{box.blend(element)} + double{box.blend(other)})});
  }
  folds.for_each_corner_at(element, [&](const CellCorner& corner) {
    const auto sign = [&](int axis) { return (corner.signs >> axis) & 1 ? -1.0 : 1.0; };
    corners_.push_back({folds.elements_of(corner),
                        {sign(0), sign(1), sign(2)},
                        folds.shares(corner, element),
                        folds.kappa(corner),
                        folds.is_guarded(corner)});
  });
}

FoldElement::Move FoldElement::move_to_least_energy(const FoldEnergy& folds,
                                                    BoxVectors& u_mm) const {
  const glm::dvec3 u = at(u_mm, element_);
  const glm::dvec3 voxels_from_mm = 1.0 / folds.box().spacing_mm();
  glm::dvec3 gradient(0.0);
  // Upper half, by rows: xx xy xz yy yz zz.
  std::array<double, 6> h{};
  const auto add_square = [&](double weight, const glm::dvec3& v) {
    h[0] += weight * v.x * v.x;
    h[1] += weight * v.x * v.y;
    h[2] += weight * v.x * v.z;
    h[3] += weight * v.y * v.y;
    h[4] += weight * v.y * v.z;
    h[5] += weight * v.z * v.z;
  };
  double energy = 0.0;
  double same = 0.0;
  for (const SpringHere& s : springs_) {
    const glm::dvec3 du = u - at(u_mm, s.other) - s.kept_mm;
    const glm::dvec3 p = s.rest_mm + du;
    const double length2 = glm::dot(p, p) + 1e-30;
    const double length = std::sqrt(length2);
    const double stretch = length - s.length_mm;
    const double plain = s.stiffness * (1.0 - s.blend);
    const double straight = s.stiffness * s.blend;
    const double relative = stretch / length;
    energy += 0.5 * (plain * stretch * stretch + straight * glm::dot(du, du));
    gradient += plain * relative * p + straight * du;
    const double across = std::max(0.0, relative);
    add_square(plain * (1.0 - across) / length2, p);
    same += plain * across + straight;
  }
  h[0] += same;
  h[3] += same;
  h[5] += same;
  std::array<glm::dvec3, 32> slopes;  // of J, by the element's position
  std::array<double, 32> open;        // J
  std::array<double, 32> least_open;
  Move result;
  const std::size_t corners = corners_.size();
  for (std::size_t i = 0; i < corners; ++i) {
    const CornerHere& c = corners_[i];
    const glm::dvec3 center = at(u_mm, c.elements[0]);
    glm::dmat3 edges(1.0);
    for (int a = 0; a < 3; ++a) {
      edges[a] += c.signs[a] * voxels_from_mm *
                  (at(u_mm, c.elements[static_cast<std::size_t>(a + 1)]) - center);
    }
    const glm::dmat3 by_edges = FoldEnergy::cofactors(edges);
    open[i] = glm::dot(edges[0], by_edges[0]);
    least_open[i] = folds.least_open(by_edges);
    slopes[i] = (by_edges * c.shares) * voxels_from_mm;
    result.in_wall = result.in_wall || open[i] < kFoldWall * kFoldReach;
    const FoldPenalty penalty = folds.penalty(open[i]);
    if (!(penalty.value > 0.0)) continue;
    energy += c.kappa * penalty.value;
    gradient += c.kappa * penalty.slope / kFoldReach * slopes[i];
    add_square(c.kappa * penalty.curvature / (kFoldReach * kFoldReach), slopes[i]);
  }
  const glm::dmat3 hessian(h[0], h[1], h[2], h[1], h[3], h[4], h[2], h[4], h[5]);
  const double volume = glm::determinant(hessian);
  if (!(volume > 0.0) || !std::isfinite(volume)) return result;
  const glm::dvec3 full = -(glm::inverse(hessian) * gradient);
  double share = 1.0;
  for (int attempt = 0; attempt < 12; ++attempt, share *= 0.5) {
    const glm::dvec3 move = share * full;
    double moved_energy = 0.0;
    bool closed = false;
    for (std::size_t i = 0; i < corners && !closed; ++i) {
      const double j = open[i] + glm::dot(slopes[i], move);
      closed = corners_[i].guarded && closes(open[i], j, kLeftByElement, least_open[i]);
      moved_energy += corners_[i].kappa * folds.penalty(j).value;
    }
    if (closed) continue;
    for (const SpringHere& s : springs_) {
      const glm::dvec3 du = u + move - at(u_mm, s.other) - s.kept_mm;
      const glm::dvec3 p = s.rest_mm + du;
      const double stretch = std::sqrt(glm::dot(p, p) + 1e-30) - s.length_mm;
      moved_energy +=
          0.5 * s.stiffness * ((1.0 - s.blend) * stretch * stretch + s.blend * glm::dot(du, du));
    }
    if (!(moved_energy <= energy)) continue;
    for (int c = 0; c < 3; ++c) {
      u_mm[static_cast<std::size_t>(c)][element_] = static_cast<float>(u[c] + move[c]);
    }
    result.voxels = glm::length(move * voxels_from_mm);
    break;
  }
  return result;
}

}  // namespace maille
