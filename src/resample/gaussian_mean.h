// Means weighted by a Gaussian of the distance, for a row of points: `rbf`.
//
//     value = sum_k w_k v_k / sum_k w_k,   w_k = exp(-(d_k / 1.4 voxels)^2),
//
// over an element and the 26 around it: Schulze, Bühler, Hadwiger (GRAPP 2007), Fig. 5, where
// "radius 1.4" is taken for a Gaussian's shape parameter. Within the range of the values that have
// a weight, and equal ones give themselves; a volume at rest would come back smoothed.
#pragma once

#include <limits>

#include "core/one_of_widths.h"
#include "volume/brick.h"

namespace maille {

class GaussianMean {
 public:
  static constexpr int kEach = 27;  // elements to a point
  static constexpr float kRadius_voxels = 1.4f;
  // Of what has no weight.
  static constexpr float kNowhere = std::numeric_limits<float>::infinity();

  // Nothing has a weight.
  GaussianMean();

  // The k-th of what point x is the mean of.
  void set(int x, int k, float squared_voxels, float value) {
    this->squared_voxels(x, k / 3)[k % 3] = squared_voxels;
    this->value(x, k / 3)[k % 3] = value;
  }
  // Three of them from the 3 row-th on, and a lane to spare that must have no weight.
  float* squared_voxels(int x, int row) { return points_[x].squared_voxels[row]; }
  float* value(int x, int row) { return points_[x].value[row]; }

  // Of the first so many points. Weights count from the nearest one's on, which cancels out: where
  // a cell is stretched over 50 voxels each would be 0.
  void compute(int points, Registers registers = Registers::widest);
  float mean(int x) const { return mean_[x]; }

  // Nine rows of three elements, and one to fill the last register.
  static constexpr int kRows = 10;
  static constexpr int kLanes = 4;
  struct Point {
    alignas(32) float squared_voxels[kRows][kLanes];
    alignas(32) float value[kRows][kLanes];
  };

 private:
  Point points_[kBrickEdge];
  float mean_[kBrickEdge];
};

}  // namespace maille
