#include "references/link_bounds.h"

#include <cmath>

namespace maille {
namespace {

// What is a whole number of units but for its binary form stays that number.
double units(double voxels) { return std::floor(voxels * kUnitsPerVoxel + 1e-9); }
double mean_units(double a_voxels, double b_voxels) {
  return std::floor((units(a_voxels) + units(b_voxels)) / 2.0);
}

}  // namespace

LinkBounds::LinkBounds(const std::vector<Material>& materials) : count_(materials.size()) {
  bounds_.reserve(3 * count_ * count_);
  for (int axis = 0; axis < 3; ++axis) {
    for (const Material& low : materials) {
      for (const Material& high : materials) {
        LinkBound bound;
        for (int c = 0; c < 3; ++c) {
          const double shear = mean_units(low.shear[c], high.shear[c]);
          const bool along = axis == c;
          bound.lower[c] = static_cast<int>(
              -(along ? mean_units(1.0 - low.compress[axis], 1.0 - high.compress[axis]) : shear));
          bound.upper[c] = static_cast<int>(
              along ? mean_units(low.stretch[axis] - 1.0, high.stretch[axis] - 1.0) : shear);
        }
        bounds_.push_back(bound);
      }
    }
  }
}

}  // namespace maille
