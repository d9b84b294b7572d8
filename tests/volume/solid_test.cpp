#include "volume/solid.h"

#include <cmath>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "volume/head_anatomy.h"

namespace maille {
namespace {

float distance_at(const Solid& solid, glm::dvec3 p) {
  const PointBlock block(p, glm::dvec3(0.001));
  std::vector<std::uint16_t> which;
  solid.select(block, which);
  PointBlock::Values distances;
  solid.evaluate(block, which, distances);
  return distances[0];
}

TEST(Solid, PrimitivesLieWhereTheySay) {
  Solid ball_only, tapered, tube, plate;
  ball_only.join(ball({1, 2, 3}, 5), 0);
  EXPECT_NEAR(distance_at(ball_only, {1, 2, 11}), 3, 1e-4);
  EXPECT_NEAR(distance_at(ball_only, {1, 2, 3}), -5, 1e-2);
  EXPECT_NEAR(distance_at(ball_only, {1, 4, 3}), -3, 1e-2);
  tapered.join(cone({0, 0, 0}, 2, {10, 0, 0}, 4), 0);
  EXPECT_NEAR(distance_at(tapered, {5, 0, 3}), 0, 1e-3);
  EXPECT_NEAR(distance_at(tapered, {17, 0, 0}), 3, 1e-3);
  tube.join(ring({0, 0, 0}, 10, 10, 1), 0);
  EXPECT_NEAR(distance_at(tube, {0, 10, 0}), -1, 1e-2);
  EXPECT_NEAR(distance_at(tube, {3, 0, 10}), 2, 1e-2);
  plate.join(facing(disc({0, 0, 0}, 10, 1), {0, 0.001, 1}), 0);
  EXPECT_NEAR(distance_at(plate, {5, 5, 3}), 2, 1e-1);
  EXPECT_NEAR(distance_at(plate, {14, 0, 0}), 4, 1e-2);
}

TEST(Solid, EllipsoidSurfacesAreExact) {
  Solid solid;
  solid.join(ellipsoid({0, 0, 0}, {3, 5, 20}), 0);
  for (const glm::dvec3 u : {glm::dvec3(1, 0, 0), glm::dvec3(0, 0, -1), glm::dvec3(0.6, 0, 0.8),
                             glm::dvec3(0.48, 0.64, 0.6)}) {
    EXPECT_NEAR(distance_at(solid, u * glm::dvec3(3, 5, 20)), 0, 1e-2);
  }
}

TEST(Solid, MirroredStandsOnBothSidesAndCarvedTakesAway) {
  Solid solid;
  solid.join(mirrored(ball({10, 0, 0}, 3)), 0);
  solid.carve(ball({-10, 0, 3}, 2), 0);
  EXPECT_LT(distance_at(solid, {10, 0, 2}), 0);
  EXPECT_LT(distance_at(solid, {-10, 0, -2}), 0);
  EXPECT_GT(distance_at(solid, {-10, 0, 2}), 0);
  EXPECT_GT(distance_at(solid, {0, 0, 0}), 0);
}

TEST(Solid, BlendingOnlyAddsAndOnlyNearby) {
  Solid sharp, smooth;
  for (Solid* solid : {&sharp, &smooth}) {
    const double blend = solid == &smooth ? 4 : 0;
    solid->join(ball({0, 0, 0}, 5), blend);
    solid->join(ball({9, 0, 0}, 5), blend);
  }
  EXPECT_LT(distance_at(smooth, {4.5, 2.5, 0}), distance_at(sharp, {4.5, 2.5, 0}));
  EXPECT_EQ(distance_at(smooth, {-6, 0, 0}), distance_at(sharp, {-6, 0, 0}));
}

// What select() promises: the primitives that it leaves out change no bit, and the range holds.
TEST(Solid, SelectionChangesNothing) {
  const HeadAnatomy head;
  std::mt19937 random(1);
  const auto unit = [&] { return static_cast<double>(random()) / 4294967296.0; };
  std::vector<std::uint16_t> which;
  PointBlock::Values selected, full;
  std::size_t left_out = 0;
  for (const Solid* solid : {&head.skin, &head.bone, &head.teeth, &head.brain, &head.air}) {
    std::vector<std::uint16_t> all(solid->primitive_count());
    std::iota(all.begin(), all.end(), std::uint16_t{0});
    for (int n = 0; n < 400; ++n) {
      const glm::dvec3 at =
          kHeadLowest + (kHeadHighest - kHeadLowest) * glm::dvec3(unit(), unit(), unit());
      const PointBlock block(at, glm::dvec3(0.3, 0.5, 0.9) * (0.2 + 4 * unit() * unit()));
      const auto range = solid->select(block, which);
      left_out += all.size() - which.size();
      solid->evaluate(block, which, selected);
      solid->evaluate(block, all, full);
      ASSERT_EQ(selected, full);
      for (const float distance : full) {
        ASSERT_GE(distance, range.lowest);
        ASSERT_LE(distance, range.highest);
      }
    }
  }
  EXPECT_GT(left_out, 10000u);
}

}  // namespace
}  // namespace maille
