#include "resample/gaussian_mean.h"

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

MAILLE_FOR_SEVERAL_WIDTHS
void weighted_means(const float (*squared_voxels)[kBrickEdge], const float (*value)[kBrickEdge],
                    int points, int each, float* mean) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  // log2(e) / r^2
  constexpr float kPerSquaredVoxel =
      1.44269504f / (GaussianMean::kRadius_voxels * GaussianMean::kRadius_voxels);
  float least[kBrickEdge];
  float weights[kBrickEdge];
  float sum[kBrickEdge];
  float lowest[kBrickEdge];
  float highest[kBrickEdge];
  for (int x = 0; x < points; ++x) {
    least[x] = squared_voxels[0][x];
    weights[x] = 0.0f;
    sum[x] = 0.0f;
    lowest[x] = kInfinity;
    highest[x] = -kInfinity;
  }
  for (int k = 1; k < each; ++k) {
    for (int x = 0; x < points; ++x) {
      least[x] = squared_voxels[k][x] < least[x] ? squared_voxels[k][x] : least[x];
    }
  }
  for (int k = 0; k < each; ++k) {
    for (int x = 0; x < points; ++x) {
      const float w = falling_power_of_two((squared_voxels[k][x] - least[x]) * kPerSquaredVoxel);
      const float v = value[k][x];
      weights[x] += w;
      sum[x] += w > 0.0f ? w * v : 0.0f;
      lowest[x] = (w > 0.0f) & (v < lowest[x]) ? v : lowest[x];
      highest[x] = (w > 0.0f) & (v > highest[x]) ? v : highest[x];
    }
  }
  for (int x = 0; x < points; ++x) {
    const float m = sum[x] / weights[x];
    const float from_below = m < lowest[x] ? lowest[x] : m;
    mean[x] = from_below > highest[x] ? highest[x] : from_below;
  }
}

}  // namespace

void GaussianMean::compute(int points, int each) {
  weighted_means(squared_voxels_, value_, points, each, mean_);
}

}  // namespace maille
