// The inverse of a cell's map, made once for all points asked of it.
#pragma once

#include <optional>
#include <vector>

#include "resample/deformed_cell.h"

namespace maille {

class CellInverse {
 public:
  // The cell must outlive it.
  CellInverse(const DeformedCell& cell, CellMap map);

  // Calls f(t) for every t in [0,1]^3, or up to `margin` (below 1/2) outside of it, whose x(t) is
  // the point: once, seldom more often in a folded cell. A nearly straight trilinear map is
  // inverted by Newton's method, any other by subdivision (cell_roots.h); a tetrahedron by its own
  // map.
  template <class F>
  void for_each_answer(glm::vec3 point, float margin, F&& f) const {
    if (!nearly_straight_) {
      for (const glm::vec3 t : answers(point, margin)) f(t);
    } else if (const auto t = by_newton(point, margin)) {
      f(*t);
    }
  }

 private:
  glm::vec3 x_of(glm::vec3 t) const;
  std::optional<glm::vec3> by_newton(glm::vec3 point, float margin) const;
  // Kept by thread, until the next are asked for.
  const std::vector<glm::vec3>& answers(glm::vec3 point, float margin) const;

  const DeformedCell& cell_;
  CellMap map_;
  Float4 constant_, x_, y_, z_, xy_, yz_, xz_, xyz_;  // coefficients of the trilinear map
  glm::vec3 center_;
  glm::mat3 t_from_x_;  // inverse Jacobian in the middle
  float bend_;          // how far, in t, the map may stray from its linear part inside the cell
  bool nearly_straight_ = false;  // and trilinear
};

}  // namespace maille
