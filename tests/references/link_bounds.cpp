#include "references/link_bounds.h"

#include <cmath>

namespace maille {

LinkBounds::LinkBounds(const std::vector<Material>& materials) : count_(materials.size()) {
  bounds_.reserve(3 * count_ * count_);
  for (int axis = 0; axis < 3; ++axis) {
    for (const Material& low : materials) {
      for (const Material& high : materials) {
        LinkBound bound;
        for (int c = 0; c < 3; ++c) {
          const double shear = (low.shear[c] + high.shear[c]) / 2.0;
          const double least =
              axis == c ? (low.compress[axis] + high.compress[axis]) / 2.0 - 1.0 : -shear;
          const double most =
              axis == c ? (low.stretch[axis] + high.stretch[axis]) / 2.0 - 1.0 : shear;
          // What is a whole number of units but for its binary form stays that number.
          bound.lower[c] = static_cast<int>(std::ceil(least * kUnitsPerVoxel - 1e-9));
          bound.upper[c] = static_cast<int>(std::floor(most * kUnitsPerVoxel + 1e-9));
        }
        bounds_.push_back(bound);
      }
    }
  }
}

}  // namespace maille
