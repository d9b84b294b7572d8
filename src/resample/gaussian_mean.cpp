#include "resample/gaussian_mean.h"

#include <algorithm>

#include "resample/quads.h"

namespace maille {
namespace {

using quads::all;
using quads::Floats;
using quads::Ints;

// 2^-y to 1e-6 of itself for y >= 0 where `counts`, else 0: the polynomial of degree 5 that is 1 at
// 0 and nearest to 2^t between -1/2 and 1/2. The standard library's exp is called point by point:
// it would take as long as everything else together.
template <int kQuads>
[[gnu::always_inline]] inline Floats<kQuads> falling_power_of_two(Floats<kQuads> y,
                                                                  Ints<kQuads> counts) {
  using F = Floats<kQuads>;
  constexpr float kOneAndAHalfTimes2To23 = 12582912.0f;
  const F limited = counts ? y : F{};
  const F whole = (limited + kOneAndAHalfTimes2To23) - kOneAndAHalfTimes2To23;
  const F t = whole - limited;
  const F power =
      1.0f +
      t * (0.69314283f +
           t * (0.240223507f + t * (0.0555740047f + t * (0.00966628252f + t * 0.00111255077f))));
  const Ints<kQuads> exponent = (127 - __builtin_convertvector(whole, Ints<kQuads>)) << 23;
  F scale;
  __builtin_memcpy(&scale, &exponent, sizeof scale);
  return counts ? power * scale : F{};
}

// What rows are joined to, the even ones in one quad and the odd ones in another.
template <int kQuads>
struct Joined {
  static constexpr int kRegisters = 2 / kQuads;
  Floats<kQuads> of[kRegisters];

  [[gnu::always_inline]] explicit Joined(float nothing) {
    for (auto& lanes : of) lanes = all<kQuads>(nothing);
  }
  // Of all lanes but the spare ones.
  template <class Join>
  [[gnu::always_inline]] float all_of(Join join) const {
    Floats<1> part[2];
    __builtin_memcpy(part, of, sizeof part);
    const Floats<1> rows = join(part[0], part[1]);
    return join(join(rows[0], rows[1]), rows[2]);
  }
};

template <int kQuads>
[[gnu::always_inline]] inline void compute_means_of(const GaussianMean::Point* points, int count,
                                                    float* mean) {
  using F = Floats<kQuads>;
  // log2(e) / r^2
  constexpr float kPerSquaredVoxel =
      1.44269504f / (GaussianMean::kRadius_voxels * GaussianMean::kRadius_voxels);
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  constexpr float kMostHalvings = 125.0f;  // before floats end
  const F none = all<kQuads>(0.0f) + kInfinity;
  constexpr int kRegisters = Joined<kQuads>::kRegisters;
  const auto lower = [](auto a, auto b) __attribute__((always_inline)) { return b < a ? b : a; };
  const auto higher = [](auto a, auto b) __attribute__((always_inline)) { return b > a ? b : a; };
  const auto sum = [](auto a, auto b) __attribute__((always_inline)) { return a + b; };
  const auto load = [](const float* from) __attribute__((always_inline)) {
    F lanes;
    __builtin_memcpy(&lanes, from, sizeof lanes);
    return lanes;
  };
  // In three loops, so that many points are under way at a time (rest_march.cpp).
  float least[kBrickEdge];
  for (int x = 0; x < count; ++x) {
    Joined<kQuads> nearest(kInfinity);
    for (int row = 0; row < GaussianMean::kRows; row += 2) {
      for (int i = 0; i < kRegisters; ++i) {
        nearest.of[i] = lower(nearest.of[i], load(points[x].squared_voxels[row + i]));
      }
    }
    least[x] = nearest.all_of(lower);
  }
  struct Sums {
    Joined<kQuads> weights{0.0f}, values{0.0f}, lowest{kInfinity}, highest{-kInfinity};
  };
  Sums sums_of[kBrickEdge];
  for (int x = 0; x < count; ++x) {
    const GaussianMean::Point& point = points[x];
    const F from = all<kQuads>(0.0f) + least[x];
    Sums sums;
    for (int row = 0; row < GaussianMean::kRows; row += 2) {
      for (int i = 0; i < kRegisters; ++i) {
        const F y = (load(point.squared_voxels[row + i]) - from) * kPerSquaredVoxel;
        // No value counts that has no weight, an infinite one among them.
        const Ints<kQuads> counts = y < kMostHalvings;
        const F w = falling_power_of_two<kQuads>(y, counts);
        const F v = load(point.value[row + i]);
        sums.weights.of[i] += w;
        sums.values.of[i] += counts ? w * v : F{};
        sums.lowest.of[i] = lower(sums.lowest.of[i], counts ? v : none);
        sums.highest.of[i] = higher(sums.highest.of[i], counts ? v : -none);
      }
    }
    sums_of[x] = sums;
  }
  for (int x = 0; x < count; ++x) {
    const Sums& sums = sums_of[x];
    const float weighted = sums.values.all_of(sum) / sums.weights.all_of(sum);
    mean[x] = std::min(std::max(weighted, sums.lowest.all_of(lower)), sums.highest.all_of(higher));
  }
}
MAILLE_ONE_OF_WIDTHS(void, compute_means, compute_means_of,
                     (const GaussianMean::Point* points, int count, float* mean),
                     (points, count, mean))

}  // namespace

GaussianMean::GaussianMean() {
  for (Point& point : points_) {
    std::fill_n(&point.squared_voxels[0][0], kRows * kLanes, kNowhere);
    std::fill_n(&point.value[0][0], kRows * kLanes, 0.0f);
  }
}

void GaussianMean::compute(int points, Registers registers) {
  const auto compute = registers == Registers::widest ? compute_means : compute_means_16;
  compute(points_, points, mean_);
}

}  // namespace maille
