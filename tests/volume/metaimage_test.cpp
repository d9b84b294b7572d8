#include <tuple>

#include <gtest/gtest.h>

#include "tests/volume/sample_files.h"

namespace maille {
namespace {

using namespace test;

constexpr int kSamples = 5 * 4 * 3;

std::string met_type(VoxelType type) {
  switch (type) {
    case VoxelType::uint8: return "MET_UCHAR";
    case VoxelType::int8: return "MET_CHAR";
    case VoxelType::uint16: return "MET_USHORT";
    case VoxelType::int16: return "MET_SHORT";
    case VoxelType::float32: break;
  }
  return "MET_FLOAT";
}

std::string header(VoxelType type, const std::string& more, const std::string& data_file) {
  return "ObjectType = Image\nNDims = 3\nBinaryData = True\nModality = MET_MOD_CT\n" + more +
         "DimSize = 5 4 3\nElementType = " + met_type(type) + "\nElementDataFile = " + data_file +
         "\n";
}

std::string short_header(const std::string& more, const std::string& data_file = "LOCAL") {
  return header(VoxelType::int16, more, data_file);
}

class MetaImageFiles : public testing::TestWithParam<std::tuple<VoxelType, bool, bool, bool>> {};

TEST_P(MetaImageFiles, HoldTheirSamples) {
  const auto& [type, is_big, is_detached, is_compressed] = GetParam();
  const Scratch folder;
  const auto samples = sample_text(type, kSamples, is_big);
  const auto data = is_compressed ? deflated(samples, 15) : samples;
  std::string more = std::string("BinaryDataByteOrderMSB = ") + (is_big ? "True\n" : "False\n");
  if (is_compressed) {
    more += "CompressedData = True\nCompressedDataSize = " + std::to_string(data.size()) + "\n";
  }
  std::filesystem::path path;
  if (is_detached) {
    folder.write("its samples.zraw", data);
    path = folder.write("scan.mhd", header(type, more, "its samples.zraw"));
  } else {
    path = folder.write("scan.mha", header(type, more, "LOCAL") + data);
  }
  const auto volume = read_volume(path);
  ASSERT_TRUE(volume.ok()) << volume.error().message;
  EXPECT_EQ(volume->size(), Size3(5, 4, 3));
  EXPECT_EQ(volume->type(), type);
  EXPECT_EQ(text_of_samples(*volume), sample_text(type, kSamples, false));
  expect_matrix(volume->world_from_voxel(), glm::dmat4(1.0));
}

INSTANTIATE_TEST_SUITE_P(All, MetaImageFiles,
                         testing::Combine(testing::ValuesIn(kAllTypes), testing::Bool(),
                                          testing::Bool(), testing::Bool()));

TEST(MetaImage, OtherSpellingsOfTheByteOrder) {
  const Scratch folder;
  for (const std::string value : {"True", "true", "T", "1"}) {
    const auto volume =
        read_volume(folder.write("scan.mha", short_header("ElementByteOrderMSB = " + value + "\n") +
                                                 sample_text(VoxelType::int16, kSamples, true)));
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(text_of_samples(*volume), sample_text(VoxelType::int16, kSamples, false));
  }
}

glm::dmat4 world_of(const std::string& fields) {
  const Scratch folder;
  const auto volume = read_volume(folder.write(
      "scan.mha", short_header(fields) + sample_text(VoxelType::int16, kSamples, false)));
  EXPECT_TRUE(volume.ok()) << volume.error().message;
  return volume.ok() ? volume->world_from_voxel() : glm::dmat4(0.0);
}

// A rotation that is not its own transpose: voxel x runs along world y, y along z, z along x.
TEST(MetaImageOrientation, RowsOfTheMatrixAreTheAxes) {
  const glm::dmat4 expected(0, 2, 0, 0, 0, 0, 3, 0, 5, 0, 0, 0, 10, -20, 30.5, 1);
  for (const std::string matrix : {"TransformMatrix", "Orientation", "Rotation"}) {
    for (const std::string offset : {"Offset", "Position", "Origin"}) {
      expect_matrix(world_of(matrix + " = 0 1 0 0 0 1 1 0 0\n" + offset +
                             " = 10 -20 30.5\nElementSpacing = 2 3 5\n"),
                    expected);
    }
  }
}

TEST(MetaImageOrientation, SpacingGoesBeforeSize) {
  expect_matrix(world_of("ElementSize = 2 3 5\n"), axis_aligned({2, 3, 5}));
  expect_matrix(world_of("ElementSize = 2 3 5\nElementSpacing = 1 1.5 0.25\n"),
                axis_aligned({1, 1.5, 0.25}));
  expect_matrix(world_of("AnatomicalOrientation = RAI\nCenterOfRotation = 1 2 3\n"), glm::dmat4(1));
}

TEST(MetaImageOrientation, WhatCannotBeIsRefused) {
  const Scratch folder;
  for (const std::string field :
       {"ElementSpacing = 1 nan 1", "ElementSpacing = 1 0 1", "ElementSpacing = 1 -1 1",
        "ElementSpacing = 1 inf 1", "ElementSpacing = 1 1", "ElementSpacing = a b c",
        "ElementSpacing = 1e-200 1e-200 1e-200", "TransformMatrix = 1 0 0 0 1 0 1 1 0",
        "TransformMatrix = 0 0 0 0 0 0 0 0 0", "TransformMatrix = 1 0 0 0 1 0 0 0",
        "TransformMatrix = 1 0 0 0 1 0 0 0 nan", "Offset = 1 2", "Offset = 1 2 inf",
        "Offset = 1 2 3 4"}) {
    expect_refused(folder.write("scan.mha", short_header(field + "\n") + std::string(120, 'x')),
                   {":5: expected "});
  }
}

TEST(MetaImageHeaderSize, SaysWhereTheSamplesStart) {
  const Scratch folder;
  const auto samples = sample_text(VoxelType::int16, kSamples, false);
  folder.write("data.raw", "1234567" + samples + "more");
  folder.write("tail.raw", "a header of unknown length" + samples);
  for (const auto& [size, file] :
       {std::pair<std::string, std::string>{"7", "data.raw"}, {"-1", "tail.raw"}}) {
    const auto volume =
        read_volume(folder.write("scan.mhd", short_header("HeaderSize = " + size + "\n", file)));
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(text_of_samples(*volume), samples);
  }
  for (const std::string size : {"-2", "x", "1000", "9223372036854775807"}) {
    expect_refused(folder.write("bad.mhd", short_header("HeaderSize = " + size + "\n", "data.raw")),
                   {":5: expected "});
  }
  expect_refused(folder.write("inside.mha", short_header("HeaderSize = 20\n") + samples),
                 {":5: expected "});
}

TEST(MetaImage, WhatIsMissingOrWrongIsRefused) {
  const Scratch folder;
  const auto good = short_header("");
  const std::string data(2 * kSamples, 'x');
  for (const std::string line : {"NDims = 3\n", "DimSize = 5 4 3\n", "ElementType = MET_SHORT\n"}) {
    expect_refused(folder.write("scan.mha", replaced(good, line, "") + data),
                   {"\"" + line.substr(0, line.find(' ')) + "\""});
  }
  expect_refused(folder.write("scan.mha", replaced(good, "ElementDataFile = LOCAL\n", "")),
                 {"\"ElementDataFile\""});
  const std::vector<std::tuple<std::string, std::string, std::string>> cases = {
      {"Image", "Tube", "Image"},
      {"NDims = 3", "NDims = 4", "3 dimensions"},
      {"NDims = 3", "NDims = 2", "3 dimensions"},
      {"DimSize = 5 4 3", "DimSize = 5 4 -3", "three sizes"},
      {"DimSize = 5 4 3", "DimSize = 5 4 0", "three sizes"},
      {"DimSize = 5 4 3", "DimSize = 5 4", "three sizes"},
      {"DimSize = 5 4 3", "DimSize = 2147483647 2147483647 2147483647", "three sizes"},
      {"MET_SHORT", "MET_INT", "8- or 16-bit integer"},
      {"MET_SHORT", "MET_DOUBLE", "8- or 16-bit integer"},
      {"BinaryData = True", "BinaryData = False", "binary data"},
      {"BinaryData = True", "BinaryData = Maybe", "True or False"},
      {"NDims = 3", "NDims = 3\nElementNumberOfChannels = 3", "1 channel"},
      {"NDims = 3", "NDims = 3\nNDims = 3", "each key once"},
      {"NDims = 3", "NDims = 3\nno equals sign", "Key = Value"},
      {"LOCAL", "LIST", "one data file"},
      {"LOCAL", "slice%03d.raw 0 2 1", "one data file"},
      {"LOCAL", "gone.raw", "gone.raw"},
      {"LOCAL", ".", "regular file"},
      {"NDims = 3", "NDims = 3\nCompressedData = True\nCompressedDataSize = 5000", "compressed"}};
  for (const auto& [from, to, expected] : cases) {
    expect_refused(folder.write("scan.mha", replaced(good, from, to) + data), {expected});
  }
}

TEST(MetaImage, ShortAndCorruptDataAreRefused) {
  const Scratch folder;
  const auto samples = sample_text(VoxelType::int16, kSamples, false);
  expect_refused(folder.write("short.mha", short_header("") + samples.substr(1)),
                 {"byte offset", "120 bytes", "got 119"});
  const auto text = short_header("CompressedData = True\n");
  const auto good = deflated(samples, 15);
  for (std::size_t length = 0; length < good.size(); ++length) {
    expect_refused(folder.write("cut.mha", text + good.substr(0, length)), {"byte offset"});
  }
  expect_refused(folder.write("noise.mha", text + std::string(200, '\x55')), {"corrupt"});
}

}  // namespace
}  // namespace maille
