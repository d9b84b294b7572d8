// The skip grid against a search through all blocks.
#include "render/skip_grid.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace maille {
namespace {

int nearest_that_shows(const SkipGrid& grid, glm::ivec3 from) {
  int nearest = SkipGrid::kFurthest_blocks;
  for (std::int64_t i = 0; i < voxel_count(grid.blocks()); ++i) {
    const glm::ivec3 block = voxel_index(i, grid.blocks());
    if (!grid.shows(block)) continue;
    const glm::ivec3 away = glm::abs(block - from);
    nearest = std::min(nearest, std::max({away.x, away.y, away.z}));
  }
  return nearest;
}

void expect_right(const SkipGrid& grid) {
  for (std::int64_t i = 0; i < voxel_count(grid.blocks()); ++i) {
    const glm::ivec3 block = voxel_index(i, grid.blocks());
    ASSERT_EQ(int{grid.distances()[static_cast<std::size_t>(i)]}, nearest_that_shows(grid, block))
        << block.x << ' ' << block.y << ' ' << block.z;
  }
}

TEST(SkipGrid, TellsHowFarTheNearestIs) {
  for (const Size3 size : {Size3(1, 1, 1), Size3(40, 1, 1), Size3(5, 44, 3), Size3(21, 18, 37)}) {
    std::mt19937 random(static_cast<unsigned>(size.x));
    SkipGrid grid(size);
    EXPECT_FALSE(grid.update());
    expect_right(grid);
    // Few and many, come and gone, several between two looks.
    for (int round = 0; round < 12; ++round) {
      const int changes = round % 3 == 0 ? 1 : static_cast<int>(random() % 40);
      for (int i = 0; i < changes; ++i) {
        const auto any = [&](int below) { return static_cast<int>(random() % unsigned(below)); };
        grid.set({any(size.x), any(size.y), any(size.z)}, round < 9 ? random() % 3 != 0 : false);
      }
      grid.update();
      expect_right(grid);
    }
    EXPECT_FALSE(grid.update()) << "nothing has changed since";
  }
}

TEST(SkipGrid, IsPaddedToWholeWords) {
  EXPECT_EQ(SkipGrid(Size3(3, 1, 1)).distances().size(), 4u);
  EXPECT_EQ(SkipGrid(Size3(3, 3, 1)).distances().size(), 12u);
}

}  // namespace
}  // namespace maille
