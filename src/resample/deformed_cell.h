// A cell of the lattice as it lies now: eight corners and the map between them, t in [0,1]^3:
//
//     x(t) = sum over corners of N(t) x_corner,
//
// with N trilinear in the cell, or linear in each of its tetrahedra.
#pragma once

#include <array>
#include <optional>

#include "core/spaces.h"

namespace maille {

// x, y, z and one lane to spare; four floats wide because every step of the map is done on all
// three components at once.
using Float4 = float __attribute__((vector_size(16)));

inline Float4 splat(float value) { return Float4{value, value, value, value}; }
inline Float4 least(Float4 a, Float4 b) { return a < b ? a : b; }
inline Float4 greatest(Float4 a, Float4 b) { return a > b ? a : b; }

// What lies between a cell's corners.
enum class CellMap {
  trilinear,
  tetrahedra,  // linear in each of the six around the diagonal from the lowest corner (Kuhn's)
};

struct DeformedCell {
  // Corner (i,j,k) at i + 2j + 4k. Positions in voxel space, relative to whatever origin keeps the
  // numbers small; the fourth lane is above 0 where the element moved.
  std::array<Float4, 8> corner;

  // Whether the map turns inside out at a corner.
  bool folded() const;
};

// The inverse of a cell's map, made once for all points asked of it. The cell must outlive it.
class CellInverse {
 public:
  CellInverse(const DeformedCell& cell, CellMap map);

  // The t whose x(t) is the point. Of the trilinear map: Newton from the middle of the cell; where
  // that does not settle (a folded or flat cell) the tetrahedra decide. The answer may lie outside
  // of [0,1]^3 by up to `margin` (below 1/2). nullopt: not in this cell.
  std::optional<glm::vec3> operator()(glm::vec3 point, float margin) const;

 private:
  std::optional<glm::vec3> by_newton(glm::vec3 point, float margin, bool& settled) const;
  std::optional<glm::vec3> by_tetrahedra(glm::vec3 point, float margin) const;

  const DeformedCell& cell_;
  Float4 constant_, x_, y_, z_, xy_, yz_, xz_, xyz_;  // coefficients of the trilinear map
  glm::vec3 center_;
  glm::mat3 t_from_x_;  // inverse Jacobian in the middle
  float bend_;          // how far, in t, the map may stray from its linear part inside the cell
  bool newton_;         // the map is trilinear, and not flat in the middle
};

}  // namespace maille
