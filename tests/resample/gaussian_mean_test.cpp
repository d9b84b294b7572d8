// Weighted means against the formula in double precision.
#include "resample/gaussian_mean.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace maille {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct Neighbour {
  float squared_voxels;
  float value;
};

GaussianMean means_of(const std::vector<std::vector<Neighbour>>& points,
                      Registers registers = Registers::widest) {
  GaussianMean mean;
  for (std::size_t x = 0; x < points.size(); ++x) {
    for (std::size_t k = 0; k < points[x].size(); ++k) {
      mean.set(static_cast<int>(x), static_cast<int>(k), points[x][k].squared_voxels,
               points[x][k].value);
    }
  }
  mean.compute(static_cast<int>(points.size()), registers);
  return mean;
}

std::vector<std::vector<Neighbour>> random_points(unsigned seed, float furthest_squared) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> squared(0.0f, furthest_squared);
  std::uniform_real_distribution<float> value(-1e3f, 1e3f);
  std::vector<std::vector<Neighbour>> points(1 + random() % kBrickEdge);
  for (auto& point : points) {
    point.resize(1 + random() % GaussianMean::kEach);
    for (Neighbour& neighbour : point) neighbour = {squared(random), value(random)};
  }
  return points;
}

TEST(GaussianMean, IsTheFormulaOfThePaper) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const auto points = random_points(seed, seed % 2 ? 9.0f : 2500.0f);
    const GaussianMean mean = means_of(points);
    for (std::size_t x = 0; x < points.size(); ++x) {
      double least = 1e300;
      for (const Neighbour& n : points[x]) least = std::min(least, double{n.squared_voxels});
      double weights = 0.0, values = 0.0, sizes = 0.0;
      for (const Neighbour& n : points[x]) {
        const double w = std::exp(-(n.squared_voxels - least) / (1.4 * 1.4));
        weights += w;
        values += w * n.value;
        sizes += w * std::abs(double{n.value});
      }
      EXPECT_NEAR(mean.mean(static_cast<int>(x)), values / weights, 3e-6 * sizes / weights)
          << "seed " << seed << ", point " << x;
    }
  }
}

TEST(GaussianMean, SameBitsForAnyWidthOfRegisters) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    auto points = random_points(seed, seed % 2 ? 9.0f : 1e4f);
    if (seed % 5 == 0) points.front().front().value = kInfinity;
    if (seed % 7 == 0) points.front().back().squared_voxels = kInfinity;
    const GaussianMean widest = means_of(points);
    const GaussianMean narrow = means_of(points, Registers::narrow);
    for (int x = 0; x < static_cast<int>(points.size()); ++x) {
      EXPECT_EQ(std::bit_cast<std::uint32_t>(widest.mean(x)),
                std::bit_cast<std::uint32_t>(narrow.mean(x)))
          << "seed " << seed;
    }
  }
}

TEST(GaussianMean, StaysAmongWhatHasAWeight) {
  std::mt19937 random(11);
  for (int round = 0; round < 500; ++round) {
    const auto points = random_points(random(), 9.0f);
    const GaussianMean mean = means_of(points);
    for (std::size_t x = 0; x < points.size(); ++x) {
      const auto [low, high] = std::minmax_element(
          points[x].begin(), points[x].end(),
          [](const Neighbour& a, const Neighbour& b) { return a.value < b.value; });
      EXPECT_GE(mean.mean(static_cast<int>(x)), low->value);
      EXPECT_LE(mean.mean(static_cast<int>(x)), high->value);
    }
  }
  // Equal ones give themselves.
  const std::vector<Neighbour> equal(GaussianMean::kEach, {0.3f, 0.1f});
  EXPECT_EQ(means_of({equal}).mean(0), 0.1f);
}

TEST(GaussianMean, WhatIsTooFarHasNoPart) {
  // Weights of e^-1250, infinite and not a number: none of these.
  const std::vector<Neighbour> far = {
      {0.5f, 7.0f}, {2500.0f, kInfinity}, {kInfinity, 3.0f}, {GaussianMean::kNowhere, -kInfinity}};
  EXPECT_EQ(means_of({far}).mean(0), 7.0f);
  // However far all of them are.
  EXPECT_NEAR(means_of({{{4e4f, 1.0f}, {4e4f, 3.0f}}}).mean(0), 2.0f, 1e-6f);
  // A weight is a weight, infinite values included.
  EXPECT_EQ(means_of({{{0.0f, 1.0f}, {1.0f, kInfinity}}}).mean(0), kInfinity);
}

}  // namespace
}  // namespace maille
