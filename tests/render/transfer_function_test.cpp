#include "render/transfer_function.h"

#include <cmath>
#include <limits>

#include <utility>

#include <gtest/gtest.h>

namespace maille {
namespace {

TEST(TransferFunction, IsLinearBetweenPointsAndConstantBeyond) {
  const auto t = TransferFunction::of({{0, {0, 0, 0}, 0.0}, {10, {1, 0.5, 0}, 0.4}});
  ASSERT_TRUE(t);
  EXPECT_EQ(t->at(-5), glm::dvec4(0, 0, 0, 0));
  EXPECT_EQ(t->at(5), glm::dvec4(0.5, 0.25, 0, 0.2));
  EXPECT_EQ(t->at(50), glm::dvec4(1, 0.5, 0, 0.4));
}

TEST(TransferFunction, AStepTakesTheUpperValue) {
  const auto t = TransferFunction::of(
      {{0, {0, 0, 0}, 0.0}, {10, {0, 0, 0}, 0.0}, {10, {1, 1, 1}, 1.0}, {20, {1, 1, 1}, 1.0}});
  ASSERT_TRUE(t);
  EXPECT_EQ(t->at(9.999).a, 0.0);
  EXPECT_EQ(t->at(10).a, 1.0);
}

TEST(TransferFunction, TableIsCorrectedForTheStep) {
  const auto t = TransferFunction::of({{0, {1, 1, 1}, 0.5}, {1, {1, 1, 1}, 0.5}});
  ASSERT_TRUE(t);
  const auto table = t->table(16, 2.0);
  ASSERT_EQ(table.size(), 16u);
  EXPECT_FLOAT_EQ(table[7].a, 0.75f);
  EXPECT_FLOAT_EQ(t->table(16, 0.5)[7].a, static_cast<float>(1.0 - std::sqrt(0.5)));
  const auto single = TransferFunction::of({{3, {1, 1, 1}, 0.5}});
  ASSERT_TRUE(single);
  EXPECT_FLOAT_EQ(single->table(4, 1.0)[3].a, 0.5f);
}

TEST(TransferFunction, RefusesWhatMeansNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(TransferFunction::of({}));
  EXPECT_FALSE(TransferFunction::of({{1, {0, 0, 0}, 0}, {0, {0, 0, 0}, 0}}));
  EXPECT_FALSE(TransferFunction::of({{nan, {0, 0, 0}, 0}}));
  EXPECT_FALSE(TransferFunction::of({{0, {0, 2, 0}, 0}}));
  EXPECT_FALSE(TransferFunction::of({{0, {0, 0, 0}, nan}}));
  const auto bad = TransferFunction::of({{0, {0, 0, 0}, 0}, {1, {0, 0, 0}, -0.1}});
  ASSERT_FALSE(bad);
  EXPECT_NE(bad.error().message.find("point 1"), std::string::npos);
}

TEST(TransferFunction, PresetsByNameOrAListOfThem) {
  for (const std::string_view name : TransferFunction::preset_names()) {
    const auto preset = TransferFunction::preset(name, -1000, 3000);
    ASSERT_TRUE(preset) << name;
    EXPECT_GT(preset->at(preset->surface_value()).a, 0.0) << name;
    EXPECT_EQ(preset->at(-1024).a, 0.0) << name;
  }
  const auto unknown = TransferFunction::preset("ct-skni", 0, 1);
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().kind, ErrorKind::usage);
  EXPECT_NE(unknown.error().message.find("ct-skin, ct-bone, ct-airway, relative"),
            std::string::npos);
}

TEST(TransferFunction, RelativeFitsTheRange) {
  const auto t = TransferFunction::preset("relative", 20, 220);
  ASSERT_TRUE(t);
  EXPECT_EQ(t->lowest(), 20);
  EXPECT_EQ(t->highest(), 220);
  EXPECT_TRUE(TransferFunction::preset("relative", 5, 5));  // a volume of one value
}

TEST(TransferFunction, IntegralsAreThoseOfDepthAndOfDepthTimesColour) {
  const auto t = TransferFunction::of(
      {{0, {1, 0, 0.5}, 0.0}, {10, {0, 1, 0.5}, 0.6}, {30, {0, 0, 1}, 0.6}, {31, {1, 1, 1}, 1.0}});
  ASSERT_TRUE(t);
  constexpr int kEntries = 311;  // a tenth of a unit apart
  constexpr double kStep = 1.7;
  const auto table = t->integrated_table(kEntries, kStep);
  ASSERT_EQ(table.size(), 3u * kEntries);
  EXPECT_FLOAT_EQ(table[200].a, static_cast<float>(-kStep * std::log(0.4)));
  EXPECT_LT(table[kEntries - 1].a, 1e3f) << "what lets nothing through has a depth all the same";
  // Between any two entries, by a sum over what lies between them.
  for (const auto& [from, to] : {std::pair(0, 90), std::pair(40, 200), std::pair(120, 290)}) {
    const glm::dvec4 got(table[std::size_t(kEntries + to)] - table[std::size_t(kEntries + from)]);
    glm::dvec4 sum(0.0);
    double place = 0.0;
    constexpr int kParts = 100'000;
    for (int i = 0; i < kParts; ++i) {
      const double value = 0.1 * (from + (i + 0.5) / kParts * (to - from));
      const glm::dvec4 entry = t->at(value);
      const double depth = -kStep * std::log(1.0 - entry.a) * (to - from) / kParts;
      sum += glm::dvec4(glm::dvec3(entry) * depth, depth);
      place += 10.0 * value * depth;
    }
    const auto of_places = [&](int i) { return double{table[std::size_t(2 * kEntries + i)].a}; };
    EXPECT_NEAR(of_places(to) - of_places(from), place, 2e-4 * place) << from << ".." << to;
    for (int c = 0; c < 4; ++c) EXPECT_NEAR(got[c], sum[c], 2e-4 * sum.a) << from << ".." << to;
  }
  // Where nothing absorbs, integrals stay what they are, to the bit.
  const auto gap =
      TransferFunction::of({{0, {1, 1, 1}, 0.3}, {1, {1, 1, 1}, 0}, {9, {0, 1, 1}, 0}});
  const auto flat = gap->integrated_table(91, 1.0);
  for (std::size_t i = 91 + 11; i < 2 * 91; ++i) EXPECT_EQ(flat[i], flat[91 + 10]);
}

}  // namespace
}  // namespace maille
