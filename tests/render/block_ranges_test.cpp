#include "render/block_ranges.h"

#include <cstring>
#include <random>

#include <gtest/gtest.h>

#include "render/volume_texture.h"

namespace maille {
namespace {

template <class T>
Volume random_volume(Size3 size, VoxelType type) {
  std::mt19937 random(3);
  std::vector<T> samples(static_cast<std::size_t>(voxel_count(size)));
  for (T& sample : samples) {
    sample = static_cast<T>(static_cast<int>(random() % 60000) - (std::is_signed_v<T> ? 30000 : 0));
  }
  return Volume::of<T>(size, type, glm::dmat4(1.0), std::move(samples));
}

BlockRanges ranges_of(const Volume& volume) {
  BlockRanges ranges(volume.size());
  const BrickGrid grid(volume.size());
  for (std::int64_t i = 0; i < grid.count(); ++i) {
    const VoxelBox box = grid.box(grid.brick(i));
    std::vector<std::byte> voxels(static_cast<std::size_t>(voxel_count(box.size())) *
                                  bytes_per_voxel(volume.type()));
    copy_brick(volume, box, voxels);
    ranges.set(grid.brick(i), ranges_of_brick(box.size(), voxels, volume.type(), 0.0f));
  }
  return ranges;
}

class BlockRangesOf : public ::testing::TestWithParam<VoxelType> {};
INSTANTIATE_TEST_SUITE_P(Types, BlockRangesOf,
                         ::testing::Values(VoxelType::uint8, VoxelType::int8, VoxelType::uint16,
                                           VoxelType::int16, VoxelType::float32),
                         [](const auto& test) { return std::string(name_of(test.param)); });

TEST_P(BlockRangesOf, HoldEveryVoxelABlockAnswersForAndNoMoreWithinABrick) {
  const Volume volume = with_voxel_type(GetParam(), [&]<class T>() {
    return random_volume<T>({70, 33, 41}, GetParam());
  });
  const BlockRanges ranges = ranges_of(volume);
  EXPECT_EQ(ranges.blocks(), Size3(9, 5, 6));
  for (int z = 0; z < ranges.blocks().z; ++z) {
    for (int y = 0; y < ranges.blocks().y; ++y) {
      for (int x = 0; x < ranges.blocks().x; ++x) {
        double low = 1e300;
        double high = -1e300;
        const glm::ivec3 lo = glm::ivec3(x, y, z) * 8;
        const glm::ivec3 hi = glm::min(lo + 9, volume.size());
        for (int k = lo.z; k < hi.z; ++k) {
          for (int j = lo.y; j < hi.y; ++j) {
            for (int i = lo.x; i < hi.x; ++i) {
              low = std::min(low, volume.value_at({i, j, k}));
              high = std::max(high, volume.value_at({i, j, k}));
            }
          }
        }
        const ValueRange range = ranges.range({x, y, z});
        EXPECT_LE(range.lowest, low);
        EXPECT_GE(range.highest, high);
        if (x % 4 != 3 && y % 4 != 3 && z % 4 != 3) {
          EXPECT_EQ(range.lowest, low);
          EXPECT_EQ(range.highest, high);
        }
      }
    }
  }
}

TEST(BlockRanges, UnknownUntilSetAndNaNIsOverwritten) {
  BlockRanges ranges({8, 8, 8});
  EXPECT_TRUE(ranges.range({0, 0, 0}).empty());
  std::vector<float> samples(512, 2.0f);
  samples[5] = std::numeric_limits<float>::quiet_NaN();
  samples[6] = -std::numeric_limits<float>::infinity();
  const auto bytes = std::as_writable_bytes(std::span(samples));
  ranges.set({0, 0, 0}, ranges_of_brick({8, 8, 8}, bytes, VoxelType::float32, -3.0f));
  EXPECT_EQ(ranges.range({0, 0, 0}).lowest, -3.0f);
  EXPECT_EQ(ranges.range({0, 0, 0}).highest, 2.0f);
  EXPECT_EQ(samples[5], -3.0f);
  EXPECT_EQ(samples[6], -3.0f);
}

}  // namespace
}  // namespace maille
