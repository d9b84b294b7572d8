// The limits of every kind of link, in 1/512 voxel: for element j one step along an axis from
// element i, u_j - u_i lies in [lower, upper] of the two elements' materials, component by
// component (the mean of both, as in Schill 1998), each rounded towards the inside and their mean
// too.
#pragma once

#include <vector>

#include "material/material_table.h"

namespace maille {

struct LinkBound {
  glm::ivec3 lower{0};  // by component
  glm::ivec3 upper{0};
};

class LinkBounds {
 public:
  explicit LinkBounds(const std::vector<Material>& materials);

  // low, high: the materials of the two elements, in the order of their indices along the axis.
  const LinkBound& of(int axis, MaterialId low, MaterialId high) const {
    return bounds_[(static_cast<std::size_t>(axis) * count_ + low) * count_ + high];
  }
  // The same for a step from one element to a neighbour: side is the sign of the step.
  const LinkBound& between(int axis, int side, MaterialId from, MaterialId to) const {
    return side > 0 ? of(axis, from, to) : of(axis, to, from);
  }

 private:
  std::size_t count_;
  std::vector<LinkBound> bounds_;
};

// Where an element has to be, at u_j now, for its link from an element at u_i to be within limits:
// the least change of each component.
inline glm::ivec3 pulled_within(const LinkBound& bound, int side, glm::ivec3 u_i, glm::ivec3 u_j) {
  return side > 0 ? glm::clamp(u_j, u_i + bound.lower, u_i + bound.upper)
                  : glm::clamp(u_j, u_i - bound.upper, u_i - bound.lower);
}

}  // namespace maille
