#include "deform/carving.h"

#include <limits>

#include <gtest/gtest.h>

#include "deform/anchors.h"
#include "deform/cutting.h"
#include "tests/deform/lattices.h"

namespace maille {
namespace {

using testing::consistent;
using testing::for_each_link_of;
using testing::for_each_voxel;
using testing::place_of;
using testing::random_lattice;

bool in_ball(const Lattice& lattice, VoxelIndex voxel, glm::dvec3 center, double radius) {
  const glm::dvec3 offset = place_of(lattice, voxel) - center;
  return glm::dot(offset, offset) <= radius * radius;
}

class CarvingAtRandom : public ::testing::TestWithParam<int> {};

// Carving, cutting and restoring at random, against a plain model of the same rules.
TEST_P(CarvingAtRandom, FollowsThePlainRules) {
  const int seed = GetParam();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(static_cast<unsigned>(seed));
  std::uniform_real_distribution<double> number(0, 1);
  const Size3 size{40, 35, 34};
  const Lattice lattice = random_lattice(size, seed % 2 ? 200 : 3000, 0.4, random);
  const auto at = [&](VoxelIndex v) { return static_cast<std::size_t>(linear_index(v, size)); };
  std::vector<char> carved(at(size - 1) + 1);
  std::vector<std::array<char, 3>> removed(carved.size());
  Cuts cuts(size);
  for (int step = 0; step < 10; ++step) {
    const glm::dvec3 center =
        glm::dvec3(number(random), number(random), number(random)) * 1.2 * glm::dvec3(size) - 3.0;
    const double radius = 12.0 * number(random);
    const auto in = [&](VoxelIndex v) { return in_ball(lattice, v, center, radius); };
    const int what = static_cast<int>(random() % 3);
    if (what == 0) {
      cuts = carve(cuts, lattice, center, radius);
      for_each_voxel(size, [&](VoxelIndex v) { carved[at(v)] |= in(v); });
      for_each_link_of(size, [&](VoxelIndex lower, int axis, VoxelIndex upper) {
        if (in(lower) || in(upper)) removed[at(lower)][static_cast<std::size_t>(axis)] = 1;
      });
    } else if (what == 1) {
      cuts = restore(cuts, lattice, center, radius);
      for_each_voxel(size, [&](VoxelIndex v) { carved[at(v)] &= !in(v); });
      for_each_link_of(size, [&](VoxelIndex lower, int axis, VoxelIndex upper) {
        if ((in(lower) && !carved[at(upper)]) || (in(upper) && !carved[at(lower)])) {
          removed[at(lower)][static_cast<std::size_t>(axis)] = 0;
        }
      });
    } else {
      const auto disc = CutSurface::disc(center, {1, 2, -1}, radius + 1, glm::dvec3(1));
      ASSERT_TRUE(disc.ok());
      const auto with_cut = cut_along(cuts, lattice, *disc);
      ASSERT_TRUE(with_cut.ok());
      for_each_link_of(size, [&](VoxelIndex lower, int axis, VoxelIndex) {
        removed[at(lower)][static_cast<std::size_t>(axis)] |= with_cut->removed(lower, axis);
        // A cut alone takes links out, and brings none back.
        ASSERT_LE(cuts.removed(lower, axis), with_cut->removed(lower, axis));
      });
      cuts = *with_cut;
    }
    ASSERT_TRUE(consistent(cuts));
    for_each_voxel(size, [&](VoxelIndex v) { ASSERT_EQ(cuts.carved(v), carved[at(v)] != 0); });
    for_each_link_of(size, [&](VoxelIndex lower, int axis, VoxelIndex) {
      ASSERT_EQ(cuts.removed(lower, axis), removed[at(lower)][static_cast<std::size_t>(axis)] != 0);
    });
  }
  EXPECT_TRUE(restore(cuts, lattice, glm::dvec3(size) * 0.5, 100.0).empty());
}

INSTANTIATE_TEST_SUITE_P(Seeds, CarvingAtRandom, ::testing::Range(1, 9));

TEST(Carving, TakesTheBallThatAGrabTakes) {
  const Size3 size{40, 40, 40};
  const Lattice rest(size);
  for (const VoxelIndex center : {VoxelIndex(31, 32, 20), VoxelIndex(0, 39, 5)}) {
    for (const double radius : {0.0, 1.0, 2.5, 9.0}) {
      const Cuts cuts = carve(Cuts(size), rest, glm::dvec3(center), radius);
      const ElementSet grab = ball_of_elements(center, radius, rest.grid());
      for_each_voxel(
          size, [&](VoxelIndex v) { ASSERT_EQ(cuts.carved(v), grab.contains(v, rest.grid())); });
      EXPECT_TRUE(consistent(cuts));
      EXPECT_TRUE(restore(cuts, rest, glm::dvec3(center), radius).empty());
    }
  }
}

// Where links that belong to three other bricks go, and come back.
TEST(Carving, AcrossBrickBorders) {
  const Size3 size{64, 64, 64};
  const Lattice rest(size);
  const Cuts cuts = carve(Cuts(size), rest, {32, 32, 32}, 0);
  std::int64_t bricks = 0;
  cuts.for_each_brick([&](std::int64_t, const CutBrick&) { ++bricks; });
  EXPECT_EQ(bricks, 4);
  EXPECT_EQ(testing::removed_links(cuts), 6);
  EXPECT_TRUE(cuts.removed({31, 32, 32}, 0));
  EXPECT_TRUE(cuts.removed({32, 31, 32}, 1));
  EXPECT_TRUE(cuts.removed({32, 32, 31}, 2));
  // A ball beside it that holds one of the other ends brings no link of a carved element back.
  const Cuts beside = restore(cuts, rest, {31, 32, 32}, 0);
  Cuts::for_each_difference(cuts, beside, [](std::int64_t b) { ADD_FAILURE() << b; });
  EXPECT_TRUE(restore(cuts, rest, {32, 32, 32}, 0).empty());
}

TEST(Carving, RestoresWhatACutRemoved) {
  const Size3 size{40, 40, 40};
  const Lattice rest(size);
  const auto disc = CutSurface::disc({20, 20, 20.5}, {0, 0, 1}, 10, glm::dvec3(1));
  ASSERT_TRUE(disc.ok());
  const auto cuts = cut_along(Cuts(size), rest, *disc);
  ASSERT_TRUE(cuts.ok());
  EXPECT_TRUE(cuts->removed({20, 20, 20}, 2));
  const Cuts part = restore(*cuts, rest, {20, 20, 20}, 3);
  EXPECT_FALSE(part.removed({20, 20, 20}, 2));
  EXPECT_TRUE(part.removed({26, 20, 20}, 2));
  EXPECT_TRUE(restore(part, rest, {20, 20, 20}, 12).empty());
}

TEST(Carving, OddBalls) {
  const Size3 size{20, 20, 20};
  const Lattice rest(size);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinite = std::numeric_limits<double>::infinity();
  const Cuts none(size);
  EXPECT_TRUE(carve(none, rest, {5, 5, 5}, -1.0).empty());
  EXPECT_TRUE(carve(none, rest, {5, 5, 5}, nan).empty());
  EXPECT_TRUE(carve(none, rest, {5, nan, 5}, 3.0).empty());
  EXPECT_TRUE(carve(none, rest, {500, 5, 5}, 3.0).empty());
  EXPECT_TRUE(carve(none, rest, {1e300, 5, 5}, 3.0).empty());
  EXPECT_TRUE(carve(none, rest, {5.5, 5.5, 5.5}, 0.5).empty());
  const Cuts all = carve(none, rest, {5, 5, 5}, infinite);
  EXPECT_TRUE(all.carved({19, 19, 19}));
  EXPECT_TRUE(consistent(all));
  EXPECT_TRUE(restore(all, rest, {5, 5, 5}, infinite).empty());
}

}  // namespace
}  // namespace maille
