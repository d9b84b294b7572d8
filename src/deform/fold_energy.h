// What keeps cells from folding while springs relax.
//
// A cell is folded where the determinant J of the three edges at one of its eight corners, in units
// of the cell at rest, is not above 0. Springs alone cannot prevent it: a cell turned inside out is
// as long along every spring as one that is not. So a corner has an energy of its own,
//
//     E = kappa (1 - J / J0)^2   for J from 0 to J0 = 0.3, none above, and straight on below 0,
//
// kappa the mean stiffness of its three links times the 2/3 power of the cell's volume in mm^3.
// Where no corner comes below J0 the equilibrium is that of the springs alone, exactly; where some
// do it is unique where theirs is not (they buckle). A corner that cuts have opened, or one beyond
// the volume, has none.
//
// The roads not taken: a logarithm at J = 0 needs no second guard but makes its few cells rule the
// step of all others (2 to 20 % of a step); limits as springs change what no fold threatens;
// clamping to the limits undoes the relaxation (maille measure error --stage relaxation has all).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "deform/spring_box.h"

namespace maille {

inline constexpr double kFoldReach = 0.3;  // J0

// E / kappa and its derivatives by J / J0. Straight below 0: what ChainMail left folded would else
// outweigh all that is not.
struct FoldPenalty {
  double value = 0.0;
  double slope = 0.0;
  double curvature = 0.0;
};
inline FoldPenalty fold_penalty(double determinant) {
  const double left = 1.0 - determinant / kFoldReach;
  if (left <= 0.0) return {};
  if (left > 1.0) return {2.0 * left - 1.0, -2.0, 0.0};
  return {left * left, -2.0 * left, 2.0};
}

// An element of the box and the signs of three steps from it: bit a set, the one along axis a is
// downwards.
struct CellCorner {
  std::int64_t element = 0;
  std::uint8_t signs = 0;

  bool operator==(const CellCorner&) const = default;
  auto operator<=>(const CellCorner&) const = default;
};

// Three edges at a corner as functions of the four elements there; edges point upwards.
class FoldEnergy {
 public:
  explicit FoldEnergy(const SpringBox& box);

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

  double determinant(const CellCorner& corner) const;

  // Columns: edge a over the spacing along a, in units of the cell at rest; row c: component c.
  glm::dmat3 edges(const CellCorner& corner) const;
  glm::dmat3 edges_of(const CellCorner& corner, const BoxVectors& direction) const;
  static glm::dmat3 cofactors(const glm::dmat3& e) {
    return {glm::cross(e[1], e[2]), glm::cross(e[2], e[0]), glm::cross(e[0], e[1])};
  }

  double kappa(const CellCorner& corner) const;
  double energy(const CellCorner& corner) const;
  // Adds -dE/du to the forces of the free elements among the four.
  void add_forces(const CellCorner& corner, BoxVectors& forces) const;
  // d . H d along a direction.
  double curvature(const CellCorner& corner, const BoxVectors& direction) const;

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
};

}  // namespace maille
