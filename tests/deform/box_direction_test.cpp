// What a direction keeps of the vectors that it is given, against the vectors themselves.
#include "deform/box_direction.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/deform/spring_row_scenes.h"

namespace maille {
namespace {

using testing::workers;

constexpr Size3 kExtent{37, 5, 4};

class Row {
 public:
  explicit Row(float most) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> along(-most, most);
    for (auto& part : parts_) {
      for (float& value : part) value = along(random);
    }
    parts_[1][11] = -most;
  }
  std::array<std::array<float, kExtent.x>, 3>& parts() { return parts_; }
  void set(BoxDirection& direction, std::int64_t row) const {
    direction.set_row(row, parts_[0].data(), parts_[1].data(), parts_[2].data());
  }
  static Row of(const BoxDirection& direction, std::int64_t row) {
    Row kept(0.0f);
    direction.get_row(row, kept.parts_[0].data(), kept.parts_[1].data(), kept.parts_[2].data());
    return kept;
  }

 private:
  std::array<std::array<float, kExtent.x>, 3> parts_;
};

TEST(BoxDirection, KeepsEachComponentToHalfAUnitOfWhatIsFurthestInItsRow) {
  BoxDirection direction(kExtent, workers());
  Row near(1.0f);
  Row far(1e6f);
  near.set(direction, 6);
  far.set(direction, 7);
  for (const auto& [row, given, most] : {std::tuple{6, &near, 1.0f}, std::tuple{7, &far, 1e6f}}) {
    Row kept = Row::of(direction, row);
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t x = 0; x < kExtent.x; ++x) {
        EXPECT_NEAR(kept.parts()[c][x], given->parts()[c][x], 0.5f * most / 8192.0f);
        EXPECT_EQ(kept.parts()[c][x],
                  direction.at(c, std::int64_t{row} * kExtent.x + static_cast<std::int64_t>(x)));
      }
    }
    EXPECT_NEAR(kept.parts()[1][11], -most, 0.5f * most / 8192.0f);
  }
  Row untouched = Row::of(direction, 5);
  for (const float value : untouched.parts()[0]) EXPECT_EQ(value, 0.0f);
}

TEST(BoxDirection, KeepsTheSameAgainOfWhatItKept) {
  BoxDirection direction(kExtent, workers());
  Row(0.3f).set(direction, 3);
  Row once = Row::of(direction, 3);
  once.set(direction, 4);
  EXPECT_EQ(once.parts(), Row::of(direction, 4).parts());
}

TEST(BoxDirection, TakesMovesOfAnySizeThatIsFinite) {
  BoxDirection direction(kExtent, workers());
  for (const float most : {0.0f, std::numeric_limits<float>::denorm_min(), 1e-38f, 1e-30f, 1e30f,
                           std::numeric_limits<float>::max() / 2.0f}) {
    Row(most).set(direction, 0);
    Row kept = Row::of(direction, 0);
    EXPECT_NEAR(kept.parts()[1][11], -most, 1e-33f + 1e-4f * most) << most;
    for (const auto& part : kept.parts()) {
      for (const float value : part) EXPECT_TRUE(std::isfinite(value)) << most;
    }
  }
}

}  // namespace
}  // namespace maille
