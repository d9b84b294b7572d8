#include "resample/gaussian_mean.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

#include "core/nearest_whole.h"
#include "core/several_widths.h"

namespace maille {
namespace {

// 2^-y to 3e-7 of itself for y >= 0, and 0 where floats end. The standard library's exp is called
// point by point: it would take as long as everything else together.
[[gnu::always_inline]] inline float falling_power_of_two(float y) {
  constexpr float kMost = 125.0f;
  const float limited = y < kMost ? y : kMost;
  const float whole = nearest_whole(limited);
  const float x = (whole - limited) * 0.693147181f;
  const float power =
      1.0f +
      x * (1.0f + x * (0.5f + x * (0.166666667f + x * (0.0416666667f + x * (0.00833333333f +
                                                                            x * 0.00138888889f)))));
  const float scale = std::bit_cast<float>((127 - static_cast<std::int32_t>(whole)) << 23);
  return y < kMost ? power * scale : 0.0f;
}

// What has been taken of a row of means.
struct Sums {
  alignas(64) float weights[kBrickEdge];
  alignas(64) float values[kBrickEdge];
  alignas(64) float lowest[kBrickEdge];
  alignas(64) float highest[kBrickEdge];
};

MAILLE_FOR_SEVERAL_WIDTHS
void take(const float* squared_voxels, const float* value, const float* least, int points,
          Sums& to) {
  // log2(e) / r^2
  constexpr float kPerSquaredVoxel =
      1.44269504f / (GaussianMean::kRadius_voxels * GaussianMean::kRadius_voxels);
  for (int x = 0; x < points; ++x) {
    const float w = falling_power_of_two((squared_voxels[x] - least[x]) * kPerSquaredVoxel);
    // No value counts that has no weight, an infinite one among them.
    const float v = value[x];
    const float weighted = w * v;
    const float lowest = to.lowest[x];
    const float highest = to.highest[x];
    const float lower = v < lowest ? v : lowest;
    const float higher = v > highest ? v : highest;
    to.weights[x] += w;
    to.values[x] += w > 0.0f ? weighted : 0.0f;
    to.lowest[x] = w > 0.0f ? lower : lowest;
    to.highest[x] = w > 0.0f ? higher : highest;
  }
}

}  // namespace

void GaussianMean::compute(int points, int each) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  float least[kBrickEdge];
  std::copy_n(squared_voxels_[0], points, least);
  for (int k = 1; k < each; ++k) {
    for (int x = 0; x < points; ++x) least[x] = std::min(least[x], squared_voxels_[k][x]);
  }
  Sums sums;
  std::fill_n(sums.weights, points, 0.0f);
  std::fill_n(sums.values, points, 0.0f);
  std::fill_n(sums.lowest, points, kInfinity);
  std::fill_n(sums.highest, points, -kInfinity);
  for (int k = 0; k < each; ++k) take(squared_voxels_[k], value_[k], least, points, sums);
  for (int x = 0; x < points; ++x) {
    const float mean = sums.values[x] / sums.weights[x];
    mean_[x] = std::min(std::max(mean, sums.lowest[x]), sums.highest[x]);
  }
}

}  // namespace maille
