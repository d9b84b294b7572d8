#include "core/spaces.h"

#include <gtest/gtest.h>

namespace maille {
namespace {

TEST(Spaces, CountsPass32Bits) {
  const Size3 size(2048, 2048, 2048);
  EXPECT_EQ(voxel_count(size), std::int64_t{1} << 33);
  EXPECT_EQ(linear_index({2047, 2047, 2047}, size), (std::int64_t{1} << 33) - 1);
}

TEST(Spaces, XIsFastest) {
  const Size3 size(3, 4, 5);
  EXPECT_EQ(linear_index({1, 0, 0}, size), 1);
  EXPECT_EQ(linear_index({0, 1, 0}, size), 3);
  EXPECT_EQ(linear_index({0, 0, 1}, size), 12);
}

TEST(Spaces, ContainsIsHalfOpen) {
  const Size3 size(3, 4, 5);
  EXPECT_TRUE(contains(size, {0, 0, 0}));
  EXPECT_TRUE(contains(size, {2, 3, 4}));
  for (const VoxelIndex outside : {VoxelIndex(-1, 0, 0), VoxelIndex(3, 0, 0), VoxelIndex(0, 4, 0),
                                   VoxelIndex(0, 0, 5), VoxelIndex(0, -1, 0)}) {
    EXPECT_FALSE(contains(size, outside));
  }
}

TEST(Spaces, PointsMoveWithTheOriginAndVectorsDoNot) {
  glm::dmat4 world_from_voxel(1.0);
  world_from_voxel[0] = {0, 2, 0, 0};
  world_from_voxel[3] = {10, 20, 30, 1};
  EXPECT_EQ(transform_point(world_from_voxel, {1, 0, 3}), glm::dvec3(10, 22, 33));
  EXPECT_EQ(transform_vector(world_from_voxel, {1, 0, 3}), glm::dvec3(0, 2, 3));
}

}  // namespace
}  // namespace maille
