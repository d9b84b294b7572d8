// Means weighted by a Gaussian of the distance, for a row of points: `rbf`.
//
//     value = sum_k w_k v_k / sum_k w_k,   w_k = exp(-(d_k / 1.4 voxels)^2),
//
// over an element and the 26 around it: Schulze, Bühler, Hadwiger (GRAPP 2007), Fig. 5, where
// "radius 1.4" is taken for a Gaussian's shape parameter. Within the range of the values that have
// a weight, and equal ones give themselves; a volume at rest would come back smoothed.
#pragma once

#include "volume/brick.h"

namespace maille {

class GaussianMean {
 public:
  static constexpr int kMost = 27;
  static constexpr float kRadius_voxels = 1.4f;

  // The k-th of what point x is the mean of; each point has as many.
  void set(int x, int k, float squared_voxels, float value) {
    squared_voxels_[k][x] = squared_voxels;
    value_[k][x] = value;
  }
  // Of the first `points`, the first `each` of every one. Weights count from the nearest one's on,
  // which cancels out: where a cell is stretched over 50 voxels each would be 0.
  void compute(int points, int each);
  float value(int x) const { return mean_[x]; }

 private:
  alignas(64) float squared_voxels_[kMost][kBrickEdge];
  alignas(64) float value_[kMost][kBrickEdge];
  alignas(64) float mean_[kBrickEdge];
};

}  // namespace maille
