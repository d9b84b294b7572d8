// What keeps cells from folding while springs relax.
//
// A cell is folded where the determinant J of the three edges at one of its eight corners, in units
// of the cell at rest, is not above 0. Springs alone cannot prevent it: a cell turned inside out is
// as long along every spring as one that is not. So a corner has an energy of its own,
//
//     E = kappa ((1 - J / 0.3)^2 - (1 - J / 0.1)^2 ln(J / 0.1)),
//
// the square for J below 0.3 only, the rest, the wall, below 0.1; kappa is the mean stiffness of
// its three links times the 2/3 power of the cell's volume in mm^3. Where no corner comes below 0.3
// the equilibrium is that of the springs alone, exactly; where some do, springs alone buckle, and
// with it a pull may still leave several equilibria, close to one another in energy. A corner that
// cuts have opened, or one beyond the volume, has none.
//
// The roads not taken: without the wall hard enough a pull has its least energy beyond J = 0, so
// that corners end on whatever floor they may not cross, and there each blocks the way of those
// around it (64^3, one element dragged by ten voxels: 4416 of energy, and no way on, where there is
// a state of 2091). A logarithm all the way from J = 0.3 bends so much that few cells rule the
// step of all others. Limits as springs change what no fold threatens; clamping to the limits
// undoes the relaxation (maille measure error --stage relaxation has all).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "deform/box_direction.h"
#include "deform/spring_box.h"

namespace maille {

inline constexpr double kFoldReach = 0.3;  // J0
// Of J / J0: where the wall begins, and below what a corner is as good as folded.
inline constexpr double kFoldWall = 1.0 / 3.0;
inline constexpr double kFoldFloor = 1.0 / 3000.0;

// E / kappa and its derivatives by J / J0. Straight below the floor, and not steep: what ChainMail
// left folded would else outweigh all that is not. Steeper while what a leap has folded is opened:
// a cell that is folded is as good a rest for springs as one that is not.
inline constexpr double kFoldedSlope = 2.0;
inline constexpr double kOpeningSlope = 8.0;
struct FoldPenalty {
  double value = 0.0;
  double slope = 0.0;
  double curvature = 0.0;
};
inline FoldPenalty fold_penalty(double determinant, double folded_slope = kFoldedSlope) {
  const double q = determinant / kFoldReach;
  if (q >= 1.0) return {};
  const double at = std::max(q, kFoldFloor);
  FoldPenalty penalty{(1.0 - at) * (1.0 - at), -2.0 * (1.0 - at), 2.0};
  if (at < kFoldWall) {
    const double s = at / kFoldWall;
    const double log = std::log(s);
    penalty.value -= (1.0 - s) * (1.0 - s) * log;
    penalty.slope += (2.0 * (1.0 - s) * log - (1.0 - s) * (1.0 - s) / s) / kFoldWall;
    penalty.curvature += (-2.0 * log + 4.0 * (1.0 - s) / s + (1.0 - s) * (1.0 - s) / (s * s)) /
                         (kFoldWall * kFoldWall);
  }
  if (q < kFoldFloor) {
    return {penalty.value + folded_slope * (kFoldFloor - q), -folded_slope, 0.0};
  }
  return penalty;
}

// No step may leave less than this of what an open corner had, or of its reach.
inline constexpr double kLeft = 0.3;
inline constexpr double kLeftByElement = 0.2;
// Nor take an open corner to where its energy goes straight, and it would stay.
inline constexpr double kLeastOpen = 2.0 * kFoldFloor * kFoldReach;

// Whether a step leaves too little of a corner. least_open: FoldEnergy::least_open.
inline bool closes(double was, double now, double share, double least_open) {
  return was > 0.0 && now < std::max(share * std::min(was, kFoldReach), std::min(was, least_open));
}

// An element of the box and the signs of three steps from it: bit a set, the one along axis a is
// downwards.
struct CellCorner {
  std::int64_t element = 0;
  std::uint8_t signs = 0;

  bool operator==(const CellCorner&) const = default;
  auto operator<=>(const CellCorner&) const = default;
};

inline glm::dvec3 at_element(const BoxVectors& v, std::int64_t e) {
  return {double{v[0][e]}, double{v[1][e]}, double{v[2][e]}};
}
inline glm::dvec3 at_element(const BoxDirection& v, std::int64_t e) {
  return {double{v.at(0, e)}, double{v.at(1, e)}, double{v.at(2, e)}};
}

// Three edges at a corner as functions of the four elements there; edges point upwards.
class FoldEnergy {
 public:
  // No component of a displacement is larger than so much.
  explicit FoldEnergy(const SpringBox& box, double largest_u_voxels = 0.0);

  // The element of a corner and the three beside it.
  std::array<std::int64_t, 4> elements_of(const CellCorner& corner) const;
  // Whether all four exist, one is free, and no link between them is cut.
  bool counts(const CellCorner& corner) const;

  // The corners that an element is part of, at most 32; calls f(corner) for those that count.
  template <class F>
  void for_each_corner_at(std::int64_t element, F&& f) const {
    for (int center = 0; center < 4; ++center) {
      for (std::uint8_t signs = 0; signs < 8; ++signs) {
        CellCorner corner{element, signs};
        if (center > 0) {
          const int axis = center - 1;
          corner.element -= signed_step(axis, signs);
        }
        if (counts(corner)) f(corner);
      }
    }
  }

  // The eight of the cell whose lowest corner is an element, those that count.
  template <class F>
  void for_each_corner_of_cell(std::int64_t lowest, F&& f) const {
    for (std::uint8_t at_high = 0; at_high < 8; ++at_high) {
      std::int64_t e = lowest;
      for (int axis = 0; axis < 3; ++axis) {
        if ((at_high >> axis) & 1) e += steps_[static_cast<std::size_t>(axis)];
      }
      const CellCorner corner{e, at_high};
      if (counts(corner)) f(corner);
    }
  }

  // Its lowest element.
  std::int64_t cell_of(const CellCorner& corner) const {
    std::int64_t e = corner.element;
    for (int axis = 0; axis < 3; ++axis) {
      if ((corner.signs >> axis) & 1) e -= steps_[static_cast<std::size_t>(axis)];
    }
    return e;
  }
  // Whether no step may close it: those of a cell that is folded anyway may, for there is often no
  // other way out of a knot. Rising.
  bool is_guarded(const CellCorner& corner) const {
    return !std::binary_search(folded_cells_.begin(), folded_cells_.end(), cell_of(corner));
  }
  void set_folded_cells(std::vector<std::int64_t> cells) { folded_cells_ = std::move(cells); }

  double largest_u_voxels() const { return largest_u_voxels_; }

  FoldPenalty penalty(double determinant) const { return fold_penalty(determinant, folded_slope_); }
  double folded_slope() const { return folded_slope_; }
  void set_folded_slope(double slope) { folded_slope_ = slope; }
  double edge_rounding() const { return edge_rounding_; }  // of an edge between floats, in voxels

  double determinant(const CellCorner& corner) const;
  // What no step may take the J of an open corner below, by the cofactors of its edges.
  double least_open(const glm::dmat3& by_edges) const {
    return kLeastOpen + edge_rounding_ * (glm::length(by_edges[0]) + glm::length(by_edges[1]) +
                                          glm::length(by_edges[2]));
  }

  // Columns: edge a over the spacing along a, in units of the cell at rest; row c: component c.
  glm::dmat3 edges(const CellCorner& corner) const;
  template <class Vectors>
  glm::dmat3 edges_of(const CellCorner& corner, const Vectors& direction) const {
    const auto elements = elements_of(corner);
    glm::dmat3 edges;
    for (int axis = 0; axis < 3; ++axis) {
      const double sign = (corner.signs >> axis) & 1 ? -1.0 : 1.0;
      edges[axis] = sign *
                    (at_element(direction, elements[static_cast<std::size_t>(axis + 1)]) -
                     at_element(direction, elements[0])) /
                    box_.spacing_mm();
    }
    return edges;
  }
  static glm::dmat3 cofactors(const glm::dmat3& e) {
    return {glm::cross(e[1], e[2]), glm::cross(e[2], e[0]), glm::cross(e[0], e[1])};
  }

  double kappa(const CellCorner& corner) const;
  double energy(const CellCorner& corner) const;
  // Adds -dE/du to the forces of the free elements among the four.
  void add_forces(const CellCorner& corner, BoxVectors& forces) const;
  // d . H d along a direction.
  double curvature(const CellCorner& corner, const BoxDirection& direction) const;

  // The share of an edge that moves with an element of the corner: edge a = ... + share[a] * u.
  glm::dvec3 shares(const CellCorner& corner, std::int64_t element) const;

  std::int64_t signed_step(int axis, std::uint8_t signs) const {
    return (signs >> axis) & 1 ? -steps_[static_cast<std::size_t>(axis)]
                               : steps_[static_cast<std::size_t>(axis)];
  }
  const SpringBox& box() const { return box_; }

 private:
  const SpringBox& box_;
  std::array<std::int64_t, 3> steps_;
  std::array<int, 3> springs_;  // the even axis springs
  double area_mm2_;             // the cell's volume to the power of 2/3
  std::vector<std::int64_t> folded_cells_;
  double largest_u_voxels_;
  double edge_rounding_;
  double folded_slope_ = kFoldedSlope;
};

}  // namespace maille
