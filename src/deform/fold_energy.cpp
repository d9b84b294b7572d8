#include "deform/fold_energy.h"

#include <algorithm>
#include <cmath>

namespace maille {

FoldEnergy::FoldEnergy(const SpringBox& box, double largest_u_voxels)
    : box_(box),
      steps_{box.step(0), box.step(2), box.step(4)},
      springs_{0, 2, 4},
      area_mm2_(
          std::cbrt(std::pow(box.spacing_mm().x * box.spacing_mm().y * box.spacing_mm().z, 2.0))),
      largest_u_voxels_(largest_u_voxels),
      // Each end of an edge is rounded when it moves, and again when they are subtracted.
      edge_rounding_(8.0 * 0x1p-24 * (1.0 + largest_u_voxels)) {}

std::array<std::int64_t, 4> FoldEnergy::elements_of(const CellCorner& corner) const {
  const std::int64_t e = corner.element;
  return {e, e + signed_step(0, corner.signs), e + signed_step(1, corner.signs),
          e + signed_step(2, corner.signs)};
}

bool FoldEnergy::counts(const CellCorner& corner) const {
  const auto elements = elements_of(corner);
  const Size3 extent = box_.extent();
  const std::int64_t count = voxel_count(extent);
  if (corner.element < 0 || corner.element >= count) return false;
  const std::int64_t row = corner.element / extent.x;
  const glm::ivec3 at(static_cast<int>(corner.element - row * extent.x),
                      static_cast<int>(row % extent.y), static_cast<int>(row / extent.y));
  bool free = box_.is_free(corner.element);
  for (int axis = 0; axis < 3; ++axis) {
    const int beside = at[axis] + ((corner.signs >> axis) & 1 ? -1 : 1);
    if (beside < 0 || beside >= extent[axis]) return false;
    free = free || box_.is_free(elements[static_cast<std::size_t>(axis + 1)]);
  }
  if (!free) return false;
  if (!box_.may_lack_springs()) return true;
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t a = static_cast<std::size_t>(axis);
    const std::int64_t lower = std::min(elements[0], elements[a + 1]);
    if (!(box_.stiffness(lower, springs_[a]) > 0.0f)) return false;
  }
  return true;
}

glm::dmat3 FoldEnergy::edges(const CellCorner& corner) const {
  return glm::dmat3(1.0) + edges_of(corner, box_.u_mm());
}

double FoldEnergy::determinant(const CellCorner& corner) const {
  return glm::determinant(edges(corner));
}

double FoldEnergy::kappa(const CellCorner& corner) const {
  if (!box_.compliances()) return area_mm2_ / double{box_.one_compliance()};
  const auto elements = elements_of(corner);
  double sum = 0.0;
  for (std::size_t a = 0; a < 3; ++a) {
    sum += double{box_.stiffness(std::min(elements[0], elements[a + 1]), springs_[a])};
  }
  return sum / 3.0 * area_mm2_;
}

double FoldEnergy::energy(const CellCorner& corner) const {
  const FoldPenalty penalty = fold_penalty(determinant(corner));
  return penalty.value > 0.0 ? kappa(corner) * penalty.value : 0.0;
}

glm::dvec3 FoldEnergy::shares(const CellCorner& corner, std::int64_t element) const {
  const auto elements = elements_of(corner);
  glm::dvec3 shares(0.0);
  for (int axis = 0; axis < 3; ++axis) {
    const double sign = (corner.signs >> axis) & 1 ? -1.0 : 1.0;
    if (element == elements[0]) shares[axis] = -sign;
    if (element == elements[static_cast<std::size_t>(axis + 1)]) shares[axis] = sign;
  }
  return shares;
}

void FoldEnergy::add_forces(const CellCorner& corner, BoxVectors& forces) const {
  const glm::dmat3 e = edges(corner);
  const FoldPenalty penalty = fold_penalty(glm::determinant(e));
  if (!(penalty.value > 0.0)) return;
  const glm::dmat3 by_edges = cofactors(e);
  const double strength = -kappa(corner) * penalty.slope / kFoldReach;
  for (const std::int64_t element : elements_of(corner)) {
    if (!box_.is_free(element)) continue;
    const glm::dvec3 force = strength * (by_edges * shares(corner, element)) / box_.spacing_mm();
    for (int c = 0; c < 3; ++c) {
      forces[static_cast<std::size_t>(c)][element] += static_cast<float>(force[c]);
    }
  }
}

double FoldEnergy::curvature(const CellCorner& corner, const BoxDirection& direction) const {
  const glm::dmat3 e = edges(corner);
  const FoldPenalty penalty = fold_penalty(glm::determinant(e));
  if (!(penalty.value > 0.0)) return 0.0;
  // J along the direction, to second order: J + first * s + second * s^2.
  const glm::dmat3 d = edges_of(corner, direction);
  const glm::dmat3 cofactors_e = cofactors(e);
  const glm::dmat3 cofactors_d = cofactors(d);
  double first = 0.0;
  double second = 0.0;
  for (int a = 0; a < 3; ++a) {
    first += glm::dot(cofactors_e[a], d[a]);
    second += glm::dot(cofactors_d[a], e[a]);
  }
  return kappa(corner) * (penalty.curvature * first * first / (kFoldReach * kFoldReach) +
                          2.0 * penalty.slope * second / kFoldReach);
}

}  // namespace maille
