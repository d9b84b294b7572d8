#include <gtest/gtest.h>

#include "tests/volume/sample_files.h"

namespace maille {
namespace {

using namespace test;

TEST(RawFile, TheNameSaysWhatItHolds) {
  const std::vector<std::pair<VoxelType, std::vector<std::string>>> names = {
      {VoxelType::uint8, {"uint8", "u8", "UINT8"}},
      {VoxelType::int8, {"int8", "i8"}},
      {VoxelType::uint16, {"uint16", "u16"}},
      {VoxelType::int16, {"int16", "i16"}},
      {VoxelType::float32, {"float32", "f32"}}};
  const Scratch folder;
  for (const auto& [type, spellings] : names) {
    for (const auto& name : spellings) {
      const auto samples = sample_text(type, 60, false);
      const auto volume = read_volume(folder.write("my_head_2_5x4x3_" + name + ".raw", samples));
      ASSERT_TRUE(volume.ok()) << volume.error().message;
      EXPECT_EQ(volume->size(), Size3(5, 4, 3));
      EXPECT_EQ(volume->type(), type);
      EXPECT_EQ(text_of_samples(*volume), samples);
      expect_matrix(volume->world_from_voxel(), glm::dmat4(1.0));
    }
  }
}

TEST(RawFile, TheSizeMustMatchToTheByte) {
  const Scratch folder;
  for (const std::size_t size : {0, 119, 121}) {
    expect_refused(folder.write("a_5x4x3_int16.raw", std::string(size, 'x')),
                   {"120 bytes", "got " + std::to_string(size)});
  }
  expect_refused(folder.write("a_2147483647x2147483647x1_uint8.raw", "x"),
                 {"4611686014132420609 bytes", "got 1"});
}

TEST(RawFile, OtherNamesAreRefused) {
  const Scratch folder;
  for (const std::string name :
       {"head.raw", "a_5x4x3.raw", "a_5x4x3_int32.raw", "a_5x4_int16.raw", "a_5x4x3x1_int16.raw",
        "a_0x4x3_int16.raw", "a_-5x4x3_int16.raw", "a_5x4x3 _int16.raw", "a_int16.raw",
        "5x4x3_int16.raw", "_.raw", "__.raw", ".raw.raw", "a_5xxx4x3_double.raw",
        "a_99999999999x1x1_int16.raw", "a_2147483647x2147483647x2147483647_float32.raw"}) {
    expect_refused(folder.write(name, std::string(120, 'x')), {"NAME_XxYxZ_TYPE.raw"});
  }
}

}  // namespace
}  // namespace maille
