#include "volume/volume.h"

#include <gtest/gtest.h>

namespace maille {
namespace {

TEST(Volume, CopiesShareTheirSamples) {
  const Volume a = Volume::of<std::int16_t>({2, 2, 1}, VoxelType::int16, axis_aligned({1, 2, 3}),
                                            {1, -2, 3, -4});
  const Volume b = a;
  EXPECT_EQ(a.bytes().data(), b.bytes().data());
  EXPECT_EQ(b.value_at({0, 1, 0}), 3);
  EXPECT_EQ(b.value_at({1, 1, 0}), -4);
  EXPECT_EQ(b.voxels<std::int16_t>()[1], -2);
  EXPECT_EQ(b.bytes().size(), 8u);
}

TEST(Volume, SpacingIsTheLengthOfTheAxes) {
  glm::dmat4 world(1.0);
  world[0] = {0, -3, 4, 0};
  world[1] = {2, 0, 0, 0};
  const Volume volume = Volume::of<std::uint8_t>({1, 1, 1}, VoxelType::uint8, world, {0});
  EXPECT_EQ(volume.spacing_mm(), glm::dvec3(5, 2, 1));
}

TEST(VoxelType, NamesAndWidths) {
  EXPECT_EQ(name_of(VoxelType::uint8), "uint8");
  EXPECT_EQ(name_of(VoxelType::int8), "int8");
  EXPECT_EQ(name_of(VoxelType::uint16), "uint16");
  EXPECT_EQ(name_of(VoxelType::int16), "int16");
  EXPECT_EQ(name_of(VoxelType::float32), "float32");
  EXPECT_EQ(bytes_per_voxel(VoxelType::int8), 1u);
  EXPECT_EQ(bytes_per_voxel(VoxelType::uint16), 2u);
  EXPECT_EQ(bytes_per_voxel(VoxelType::float32), 4u);
}

}  // namespace
}  // namespace maille
