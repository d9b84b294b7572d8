#include "deform/bfloat16.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace maille {
namespace {

TEST(Bfloat16, KeepsWhatFitsAndRoundsTheRestToTheNearest) {
  for (const float exact : {0.0f, 1.0f, -1.0f, 1.5f, 255.0f, 0x1p-100f}) {
    EXPECT_EQ(static_cast<float>(Bfloat16(exact)), exact);
  }
  // Neighbours of 1 are 1/128 apart; halfway goes to the even one.
  EXPECT_EQ(static_cast<float>(Bfloat16(1.0f + 1.0f / 256.0f)), 1.0f);
  EXPECT_EQ(static_cast<float>(Bfloat16(1.0f + 3.0f / 256.0f)), 1.0f + 4.0f / 256.0f);
  EXPECT_EQ(static_cast<float>(Bfloat16(1.0f + 1.1f / 256.0f)), 1.0f + 2.0f / 256.0f);
  std::mt19937 random(1);
  std::uniform_real_distribution<float> power(-60, 60);
  for (int i = 0; i < 1000; ++i) {
    const float value = std::exp2(power(random));
    EXPECT_NEAR(static_cast<float>(Bfloat16(value)), value, value / 256.0f);
  }
}

}  // namespace
}  // namespace maille
