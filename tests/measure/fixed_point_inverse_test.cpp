#include "references/fixed_point_inverse.h"

#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "tests/measure/deformed_scenes.h"

namespace maille {
namespace {

using namespace testing;

double error_after(const DeformedElements& elements, glm::dvec3 rest, int iterations) {
  const glm::dvec3 point = forward_voxels(elements, rest);
  return glm::length(rest_by_fixed_point(elements, point, iterations) - rest);
}

// u = A (X - c): the error is multiplied by -A with every iteration.
TEST(FixedPointInverse, ShrinksItsErrorByTheGradient) {
  const Size3 size{40, 40, 40};
  for (const double slope : {0.05, 0.3, -0.25, -0.75}) {
    const DeformedElements elements =
        deformed(size, [&](glm::dvec3 p) { return glm::dvec3(slope * (p.x - 20.0), 0, 0); });
    const glm::dvec3 rest(21.7, 13.2, 30.9);
    const double first = std::abs(slope * slope * 1.7);  // u(x) - u(X), x - X = slope * 1.7
    for (int iterations = 1; iterations <= 8; ++iterations) {
      EXPECT_NEAR(error_after(elements, rest, iterations),
                  first * std::pow(std::abs(slope), iterations - 1), 1e-12)
          << slope << ' ' << iterations;
    }
  }
}

TEST(FixedPointInverse, ConvergesWhereverTheMapContracts) {
  const Size3 size{40, 36, 38};
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    // Nine slopes of a tenth and less: a norm of at most 0.3, between elements too.
    const DeformedElements elements = deformed(size, smooth_waves(seed, 0.1));
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    double worst[9] = {};
    for (int i = 0; i < 2000; ++i) {
      const double x = share(random);
      const double y = share(random);
      const glm::dvec3 rest = glm::dvec3(x, y, share(random)) * glm::dvec3(size - 1);
      const glm::dvec3 u = forward_voxels(elements, rest) - rest;
      double before = glm::length(u);  // no iteration: X_0 = x
      for (int iterations = 1; iterations <= 8; ++iterations) {
        const double error = error_after(elements, rest, iterations);
        ASSERT_LE(error, 0.3 * before + 1e-12);
        worst[iterations] = std::max(worst[iterations], error);
        before = error;
      }
    }
    EXPECT_GT(worst[1], 0.0);
    EXPECT_LT(worst[8], 1e-4);
  }
}

// Stretched 4 times the gradient is 3, and squeezed to a quarter 0.75: the one runs away and the
// other takes its time.
TEST(FixedPointInverse, DoesNotConvergeWhereStretched) {
  const Size3 size{64, 4, 4};
  const DeformedElements elements = deformed(size, stretched_and_squeezed(63));
  for (const int iterations : {1, 8, 100}) {
    std::int64_t off = 0;
    for (int x = 0; x < size.x; ++x) {
      const glm::dvec3 point(x, 1, 2);
      const glm::dvec3 rest = rest_by_fixed_point(elements, point, iterations);
      off += glm::length(forward_voxels(elements, rest) - point) > 0.1;
    }
    ::testing::Test::RecordProperty("off_after_" + std::to_string(iterations) + "_of_64",
                                    std::to_string(off));
    EXPECT_GT(off, size.x / 2) << iterations;
  }
}

TEST(FixedPointInverse, ItsValuesAreTrilinear) {
  const Size3 size{5, 6, 7};
  const std::vector<double> values = ramp(size);
  EXPECT_NEAR(trilinear(size, values, {1.25, 3.5, 4.75}), 3 * 1.25 - 2 * 3.5 + 0.5 * 4.75, 1e-12);
  EXPECT_EQ(trilinear(size, values, {4, 5, 6}), values.back());
  EXPECT_EQ(trilinear(size, values, {-3, -0.1, 0}), values.front());
  EXPECT_EQ(trilinear({1, 1, 1}, std::vector{7.0}, {0.3, 0, -2}), 7.0);
}

}  // namespace
}  // namespace maille
