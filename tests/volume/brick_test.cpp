#include "volume/brick.h"

#include <vector>

#include <gtest/gtest.h>

namespace maille {
namespace {

TEST(BrickGrid, BricksTileTheVolumeOnce) {
  for (const Size3 size :
       {Size3(1, 1, 1), Size3(32, 64, 96), Size3(33, 31, 65), Size3(5, 100, 7)}) {
    const BrickGrid grid(size);
    std::vector<int> hits(static_cast<std::size_t>(voxel_count(size)));
    for (std::int64_t n = 0; n < grid.count(); ++n) {
      const auto brick = grid.brick(n);
      ASSERT_EQ(grid.linear(brick), n);
      ASSERT_TRUE(grid.contains(brick));
      const auto box = grid.box(brick);
      ASSERT_FALSE(box.empty());
      for (int z = box.lo.z; z < box.hi.z; ++z) {
        for (int y = box.lo.y; y < box.hi.y; ++y) {
          for (int x = box.lo.x; x < box.hi.x; ++x) {
            ASSERT_EQ(BrickGrid::brick_of({x, y, z}), brick);
            ++hits[static_cast<std::size_t>(linear_index({x, y, z}, size))];
          }
        }
      }
    }
    for (const int count : hits) ASSERT_EQ(count, 1);
  }
}

TEST(BrickGrid, VoxelsBeforeZeroLieInBricksBeforeZero) {
  EXPECT_EQ(BrickGrid::brick_of({-1, -32, -33}), BrickIndex(-1, -1, -2));
}

TEST(VoxelBox, IntersectionsMayBeEmpty) {
  const VoxelBox a{{0, 0, 0}, {10, 10, 10}}, b{{5, -5, 9}, {20, 5, 11}}, c{{10, 0, 0}, {12, 9, 9}};
  EXPECT_EQ(intersection(a, b), (VoxelBox{{5, 0, 9}, {10, 5, 10}}));
  EXPECT_TRUE(intersection(a, c).empty());
  EXPECT_FALSE(intersection(b, b).empty());
}

}  // namespace
}  // namespace maille
