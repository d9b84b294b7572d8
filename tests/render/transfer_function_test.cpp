#include "render/transfer_function.h"

#include <cmath>
#include <limits>

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

}  // namespace
}  // namespace maille
