#include "deform/fold_batch.h"

#include <algorithm>
#include <cmath>

#include "core/several_widths.h"

// Vectors are passed between functions of this file alone, all inlined.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace maille {
namespace {

using Lanes = FoldBatch::Lanes;
using LaneMask = FoldBatch::LaneMask;

constexpr int kMostAttempts = 13;

constexpr int kSelf = kSprings;  // after the elements at the other ends of the springs

// A corner that the element in the middle is part of: which elements, by number as above.
struct CornerShape {
  int center = kSelf;
  std::array<int, 3> others{};
  std::array<double, 3> signs{};
  int axis = -1;  // of the one edge that the element in the middle ends; -1: all three begin there
};

int number_of(glm::ivec3 offset) {
  const Springs springs = springs_of(glm::dvec3(1.0));
  for (int s = 0; s < kSprings; ++s) {
    if (springs[static_cast<std::size_t>(s)].offset == offset) return s;
  }
  return kSelf;
}

// In the order of FoldEnergy::for_each_corner_at.
std::array<CornerShape, FoldBatch::kCorners> make_shapes() {
  std::array<CornerShape, FoldBatch::kCorners> shapes;
  for (int i = 0; i < FoldBatch::kCorners; ++i) {
    CornerShape& shape = shapes[static_cast<std::size_t>(i)];
    shape.axis = i / 8 - 1;
    glm::ivec3 signs;
    for (int a = 0; a < 3; ++a) signs[a] = (i >> a) & 1 ? -1 : 1;
    glm::ivec3 center(0);
    if (shape.axis >= 0) center[shape.axis] = -signs[shape.axis];
    shape.center = number_of(center);
    for (int a = 0; a < 3; ++a) {
      glm::ivec3 other = center;
      other[a] += signs[a];
      shape.others[static_cast<std::size_t>(a)] = number_of(other);
      shape.signs[static_cast<std::size_t>(a)] = signs[a];
    }
  }
  return shapes;
}

const std::array<CornerShape, FoldBatch::kCorners>& shapes() {
  static const auto all = make_shapes();
  return all;
}

struct alignas(64) Lanes3 {
  Lanes x{};
  Lanes y{};
  Lanes z{};
};
[[gnu::always_inline]] inline Lanes3 operator+(const Lanes3& a, const Lanes3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
[[gnu::always_inline]] inline Lanes3 operator-(const Lanes3& a, const Lanes3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
[[gnu::always_inline]] inline Lanes3 operator*(const Lanes& s, const Lanes3& a) {
  return {s * a.x, s * a.y, s * a.z};
}
[[gnu::always_inline]] inline Lanes3 times(const Lanes3& a, const glm::dvec3& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
[[gnu::always_inline]] inline Lanes dot(const Lanes3& a, const Lanes3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
[[gnu::always_inline]] inline Lanes3 cross(const Lanes3& a, const Lanes3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
[[gnu::always_inline]] inline Lanes root(const Lanes& a) {
  Lanes r;
  for (int l = 0; l < FoldBatch::kLanes; ++l) r[l] = std::sqrt(a[l]);
  return r;
}
[[gnu::always_inline]] inline Lanes lesser(const Lanes& a, const Lanes& b) { return a < b ? a : b; }
[[gnu::always_inline]] inline Lanes greater(const Lanes& a, const Lanes& b) {
  return a > b ? a : b;
}
[[gnu::always_inline]] inline bool any(const LaneMask& mask) {
  long long all = 0;
  for (int l = 0; l < FoldBatch::kLanes; ++l) all |= mask[l];
  return all != 0;
}
[[gnu::always_inline]] inline Lanes3 vector_of(const std::array<Lanes, 3>& a) {
  return {a[0], a[1], a[2]};
}

struct alignas(64) PenaltyLanes {
  Lanes value{};
  Lanes slope{};
  Lanes curvature{};
};
// fold_penalty of each lane.
[[gnu::always_inline]] inline PenaltyLanes penalty_of(const Lanes& determinant,
                                                      double folded_slope) {
  const Lanes zero{};
  const Lanes q = determinant / kFoldReach;
  const LaneMask near = q < 1.0;
  PenaltyLanes p{near ? (1.0 - q) * (1.0 - q) : zero, near ? -2.0 * (1.0 - q) : zero,
                 near ? zero + 2.0 : zero};
  if (!any(q < kFoldWall)) return p;
  for (int l = 0; l < FoldBatch::kLanes; ++l) {
    if (!(q[l] < kFoldWall)) continue;
    const FoldPenalty exact = fold_penalty(determinant[l], folded_slope);
    p.value[l] = exact.value;
    p.slope[l] = exact.slope;
    p.curvature[l] = exact.curvature;
  }
  return p;
}

struct alignas(64) Surroundings {
  std::array<Lanes3, kSprings + 1> u_mm;
  glm::dvec3 voxels_from_mm{1};
  double folded_slope = kFoldedSlope;
  double edge_rounding = 0.0;
};

struct alignas(64) Outcome {
  Lanes3 move_mm;
  LaneMask moves{};  // of the lanes
};

[[gnu::always_inline]] inline Lanes energy_of_springs(
    const std::array<FoldBatch::SpringLanes, kSprings>& springs, const Surroundings& around,
    const Lanes3& u) {
  Lanes energy{};
  for (std::size_t s = 0; s < kSprings; ++s) {
    const FoldBatch::SpringLanes& spring = springs[s];
    const Lanes3 du = u - around.u_mm[s] - vector_of(spring.kept_mm);
    const Lanes3 p = vector_of(spring.rest_mm) + du;
    const Lanes stretch = root(dot(p, p) + 1e-30) - spring.length_mm;
    energy += 0.5 * (spring.plain * stretch * stretch + spring.straight * dot(du, du));
  }
  return energy;
}

MAILLE_FOR_SEVERAL_WIDTHS
void find_moves(const std::array<FoldBatch::SpringLanes, kSprings>& springs,
                const std::array<FoldBatch::CornerLanes, FoldBatch::kCorners>& corners,
                const std::array<CornerShape, FoldBatch::kCorners>& shapes_of,
                const Surroundings& around, double first_share, Outcome& outcome) {
  const Lanes3 u = around.u_mm[kSelf];
  const glm::dvec3& voxels_from_mm = around.voxels_from_mm;
  const Lanes zero{};
  Lanes3 gradient;
  Lanes xx{}, xy{}, xz{}, yy{}, yz{}, zz{};
  const auto add_square = [&](const Lanes& weight, const Lanes3& v) __attribute__((always_inline)) {
    xx += weight * v.x * v.x;
    xy += weight * v.x * v.y;
    xz += weight * v.x * v.z;
    yy += weight * v.y * v.y;
    yz += weight * v.y * v.z;
    zz += weight * v.z * v.z;
  };
  Lanes energy{};
  Lanes same{};
  for (std::size_t s = 0; s < kSprings; ++s) {
    const FoldBatch::SpringLanes& spring = springs[s];
    const Lanes3 du = u - around.u_mm[s] - vector_of(spring.kept_mm);
    const Lanes3 p = vector_of(spring.rest_mm) + du;
    const Lanes length2 = dot(p, p) + 1e-30;
    const Lanes length = root(length2);
    const Lanes stretch = length - spring.length_mm;
    const Lanes relative = stretch / length;
    energy += 0.5 * (spring.plain * stretch * stretch + spring.straight * dot(du, du));
    gradient = gradient + (spring.plain * relative) * p + spring.straight * du;
    const Lanes across = greater(zero, relative);
    add_square(spring.plain * (1.0 - across) / length2, p);
    same += spring.plain * across + spring.straight;
  }
  xx += same;
  yy += same;
  zz += same;

  alignas(64) std::array<Lanes3, FoldBatch::kCorners> slopes;  // of J, by the element's position
  alignas(64) std::array<Lanes, FoldBatch::kCorners> open;     // J
  alignas(64) std::array<Lanes, FoldBatch::kCorners> least;    // that a move may leave of it
  for (std::size_t i = 0; i < FoldBatch::kCorners; ++i) {
    const FoldBatch::CornerLanes& corner = corners[i];
    if (!corner.present) continue;
    const CornerShape& shape = shapes_of[i];
    const Lanes3& center = around.u_mm[static_cast<std::size_t>(shape.center)];
    std::array<Lanes3, 3> e;
    for (std::size_t a = 0; a < 3; ++a) {
      e[a] = times(around.u_mm[static_cast<std::size_t>(shape.others[a])] - center,
                   shape.signs[a] * voxels_from_mm);
    }
    e[0].x += 1.0;
    e[1].y += 1.0;
    e[2].z += 1.0;
    if (shape.axis >= 0) {
      const auto a = static_cast<std::size_t>(shape.axis);
      const Lanes3 across = cross(e[(a + 1) % 3], e[(a + 2) % 3]);
      open[i] = dot(e[a], across);
      slopes[i] = times(across, shape.signs[a] * voxels_from_mm);
    } else {
      const Lanes3 across = cross(e[1], e[2]);
      open[i] = dot(e[0], across);
      const Lanes3 sum = times(across, glm::dvec3(shape.signs[0])) +
                         times(cross(e[2], e[0]), glm::dvec3(shape.signs[1])) +
                         times(cross(e[0], e[1]), glm::dvec3(shape.signs[2]));
      slopes[i] = times(sum, -voxels_from_mm);
    }
    // closes(), with a bound of least_open that needs no root.
    const Lanes least_open =
        kLeastOpen + around.edge_rounding * (dot(e[0], e[0]) + dot(e[1], e[1]) + dot(e[2], e[2]));
    least[i] =
        greater(kLeftByElement * lesser(open[i], zero + kFoldReach), lesser(open[i], least_open));
    least[i] = (open[i] > zero) & corner.guarded ? least[i] : zero - 1e300;
    if (!any((corner.kappa > zero) & (open[i] < kFoldReach))) continue;
    const PenaltyLanes penalty = penalty_of(open[i], around.folded_slope);
    energy += corner.kappa * penalty.value;
    gradient = gradient + (corner.kappa * penalty.slope / kFoldReach) * slopes[i];
    add_square(corner.kappa * penalty.curvature / (kFoldReach * kFoldReach), slopes[i]);
  }

  // The inverse of the Hessian by its cofactors.
  const Lanes cxx = yy * zz - yz * yz;
  const Lanes cxy = xz * yz - xy * zz;
  const Lanes cxz = xy * yz - xz * yy;
  const Lanes volume = xx * cxx + xy * cxy + xz * cxz;
  const Lanes cyy = xx * zz - xz * xz;
  const Lanes cyz = xy * xz - xx * yz;
  const Lanes czz = xx * yy - xy * xy;
  LaneMask left = (volume > zero) & (volume < zero + 1e300);
  const Lanes by = left ? -1.0 / volume : zero;
  const Lanes3 full = by * Lanes3{cxx * gradient.x + cxy * gradient.y + cxz * gradient.z,
                                  cxy * gradient.x + cyy * gradient.y + cyz * gradient.z,
                                  cxz * gradient.x + cyz * gradient.y + czz * gradient.z};
  outcome.moves = LaneMask{};
  outcome.move_mm = Lanes3{};
  double share = first_share;
  for (int attempt = 0; attempt < kMostAttempts && any(left); ++attempt) {
    const Lanes3 move = (zero + share) * full;
    LaneMask fits = left;
    Lanes moved_energy{};
    for (std::size_t i = 0; i < FoldBatch::kCorners; ++i) {
      if (!corners[i].present) continue;
      const Lanes j = open[i] + dot(slopes[i], move);
      fits &= j >= least[i];
      if (!any((corners[i].kappa > zero) & (j < kFoldReach))) continue;
      moved_energy += corners[i].kappa * penalty_of(j, around.folded_slope).value;
    }
    if (any(fits)) {
      moved_energy += energy_of_springs(springs, around, u + move);
      fits &= moved_energy <= energy;
      outcome.move_mm.x = fits ? move.x : outcome.move_mm.x;
      outcome.move_mm.y = fits ? move.y : outcome.move_mm.y;
      outcome.move_mm.z = fits ? move.z : outcome.move_mm.z;
      outcome.moves |= fits;
      left &= ~fits;
    }
    share = share > 1.0 ? 1.0 : 0.5 * share;
  }
}

}  // namespace

int FoldBatch::color_of(const SpringBox& box, std::int64_t element) {
  const Size3 extent = box.extent();
  const std::int64_t row = element / extent.x;
  return static_cast<int>(((element - row * extent.x) & 1) | (row % extent.y & 1) << 1 |
                          (row / extent.y & 1) << 2);
}

FoldBatch::FoldBatch(const FoldEnergy& folds, std::span<const std::int64_t> elements)
    : count_(static_cast<int>(elements.size())) {
  std::copy(elements.begin(), elements.end(), elements_.begin());
  const SpringBox& box = folds.box();
  for (int s = 0; s < kSprings; ++s) {
    const Spring& spring = box.springs()[static_cast<std::size_t>(s)];
    SpringLanes& lanes = springs_[static_cast<std::size_t>(s)];
    for (int c = 0; c < 3; ++c) {
      lanes.rest_mm[static_cast<std::size_t>(c)] += double{spring.rest_mm[c]};
    }
    lanes.length_mm += double{spring.length_mm};
    for (int l = 0; l < count_; ++l) {
      const std::int64_t e = elements[static_cast<std::size_t>(l)];
      const double k = double{box.stiffness(e, s)};
      if (!(k > 0.0)) continue;
      const double blend = 0.5 * (double{box.blend(e)} + double{box.blend(e + box.step(s))});
      lanes.plain[l] = k * (1.0 - blend);
      lanes.straight[l] = k * blend;
      if (!box.keeps()) continue;
      const glm::dvec3 kept_mm = box.kept_mm(e, s);
      const glm::dvec3 rest_mm = glm::dvec3(spring.rest_mm) + kept_mm;
      for (int c = 0; c < 3; ++c) {
        lanes.kept_mm[static_cast<std::size_t>(c)][l] = kept_mm[c];
        lanes.rest_mm[static_cast<std::size_t>(c)][l] = rest_mm[c];
      }
      lanes.length_mm[l] = glm::length(rest_mm);
    }
  }
  for (int l = 0; l < count_; ++l) {
    const std::int64_t e = elements[static_cast<std::size_t>(l)];
    for (int i = 0; i < kCorners; ++i) {
      CellCorner corner{e, static_cast<std::uint8_t>(i % 8)};
      if (i >= 8) corner.element -= folds.signed_step(i / 8 - 1, corner.signs);
      if (!folds.counts(corner)) continue;
      CornerLanes& lanes = corners_[static_cast<std::size_t>(i)];
      lanes.present = true;
      lanes.kappa[l] = folds.kappa(corner);
      lanes.guarded[l] = folds.is_guarded(corner) ? -1 : 0;
    }
  }
}

double FoldBatch::move_to_least_energy(const FoldEnergy& folds, BoxVectors& u_mm,
                                       double first_share) const {
  const SpringBox& box = folds.box();
  Surroundings around;
  around.voxels_from_mm = 1.0 / box.spacing_mm();
  around.folded_slope = folds.folded_slope();
  around.edge_rounding = folds.edge_rounding();
  for (int l = 0; l < count_; ++l) {
    const std::int64_t e = elements_[static_cast<std::size_t>(l)];
    for (int n = 0; n <= kSprings; ++n) {
      const std::int64_t at = n < kSprings ? e + box.step(n) : e;
      Lanes3& u = around.u_mm[static_cast<std::size_t>(n)];
      u.x[l] = double{u_mm[0][at]};
      u.y[l] = double{u_mm[1][at]};
      u.z[l] = double{u_mm[2][at]};
    }
  }
  Outcome outcome;
  find_moves(springs_, corners_, shapes(), around, first_share, outcome);
  double largest_voxels = 0.0;
  for (int l = 0; l < count_; ++l) {
    if (!outcome.moves[l]) continue;
    const std::int64_t e = elements_[static_cast<std::size_t>(l)];
    const Lanes3& u = around.u_mm[kSelf];
    const glm::dvec3 move(outcome.move_mm.x[l], outcome.move_mm.y[l], outcome.move_mm.z[l]);
    u_mm[0][e] = static_cast<float>(u.x[l] + move.x);
    u_mm[1][e] = static_cast<float>(u.y[l] + move.y);
    u_mm[2][e] = static_cast<float>(u.z[l] + move.z);
    largest_voxels = std::max(largest_voxels, glm::length(move * around.voxels_from_mm));
  }
  return largest_voxels;
}

}  // namespace maille
