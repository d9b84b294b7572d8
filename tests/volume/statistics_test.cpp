#include "volume/statistics.h"

#include <cmath>
#include <limits>
#include <numeric>

#include <gtest/gtest.h>

namespace maille {
namespace {

template <class T>
VolumeStatistics statistics_of_row(VoxelType type, std::vector<T> samples, int bins) {
  const Size3 size(static_cast<int>(samples.size()), 1, 1);
  return statistics_of(Volume::of(size, type, glm::dmat4(1.0), std::move(samples)), bins);
}

TEST(Statistics, EqualBinsWithBothEndsInside) {
  const auto s = statistics_of_row<std::int16_t>(VoxelType::int16, {-10, -9, 0, 9, 10, 10, 10}, 4);
  EXPECT_EQ(s.lowest, -10);
  EXPECT_EQ(s.highest, 10);
  EXPECT_EQ(s.nan_count, 0);
  EXPECT_EQ(s.histogram, (std::vector<std::int64_t>{2, 0, 1, 4}));
}

TEST(Statistics, TheEndsOfEveryType) {
  EXPECT_EQ(statistics_of_row<std::uint8_t>(VoxelType::uint8, {255, 0}, 2).highest, 255);
  EXPECT_EQ(statistics_of_row<std::int8_t>(VoxelType::int8, {-128, 127}, 2).lowest, -128);
  EXPECT_EQ(statistics_of_row<std::uint16_t>(VoxelType::uint16, {65535, 0}, 2).highest, 65535);
  EXPECT_EQ(statistics_of_row<std::int16_t>(VoxelType::int16, {-32768, 32767}, 2).lowest, -32768);
  const float most = std::numeric_limits<float>::max();
  const auto s = statistics_of_row<float>(VoxelType::float32, {-most, 0, most}, 3);
  EXPECT_EQ(s.highest, most);
  EXPECT_EQ(s.histogram, (std::vector<std::int64_t>{1, 1, 1}));
}

TEST(Statistics, OneValueFillsTheFirstBin) {
  const auto s = statistics_of_row<std::uint8_t>(VoxelType::uint8, {7, 7, 7}, 256);
  EXPECT_EQ(s.lowest, 7);
  EXPECT_EQ(s.highest, 7);
  EXPECT_EQ(s.histogram[0], 3);
  EXPECT_EQ(s.histogram.size(), 256u);
}

TEST(Statistics, WhatIsNotFiniteIsCountedApart) {
  const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
  auto s = statistics_of_row<float>(VoxelType::float32, {nan, 1, -inf, 3, inf}, 2);
  EXPECT_EQ(s.nan_count, 3);
  EXPECT_EQ(s.lowest, 1);
  EXPECT_EQ(s.highest, 3);
  EXPECT_EQ(s.histogram, (std::vector<std::int64_t>{1, 1}));
  s = statistics_of_row<float>(VoxelType::float32, {nan, inf}, 2);
  EXPECT_EQ(s.nan_count, 2);
  EXPECT_EQ(s.lowest, 0);
  EXPECT_EQ(s.highest, 0);
  EXPECT_EQ(s.histogram, (std::vector<std::int64_t>{0, 0}));
}

TEST(Statistics, AgreeWithCountingOneByOne) {
  std::vector<std::uint16_t> samples(10007);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i] = static_cast<std::uint16_t>(100 + i * i % 4321);
  }
  const auto s = statistics_of_row(VoxelType::uint16, samples, 100);
  std::vector<std::int64_t> expected(100);
  for (const auto value : samples) {
    const double t = (value - s.lowest) / (s.highest - s.lowest);
    ++expected[std::min<std::size_t>(static_cast<std::size_t>(t * 100), 99)];
  }
  std::int64_t moved = 0;  // a sample on a bin's border may fall to either side
  for (std::size_t bin = 0; bin < 100; ++bin) moved += std::abs(expected[bin] - s.histogram[bin]);
  EXPECT_LE(moved, 20);
  EXPECT_EQ(std::accumulate(s.histogram.begin(), s.histogram.end(), std::int64_t{0}), 10007);
}

}  // namespace
}  // namespace maille
