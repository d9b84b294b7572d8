#include <tuple>

#include <gtest/gtest.h>

#include "tests/volume/sample_files.h"

namespace maille {
namespace {

using namespace test;

constexpr int kSamples = 5 * 4 * 3;

std::string nrrd_type(VoxelType type) {
  switch (type) {
    case VoxelType::uint8: return "unsigned char";
    case VoxelType::int8: return "signed char";
    case VoxelType::uint16: return "unsigned short";
    case VoxelType::int16: return "short";
    case VoxelType::float32: break;
  }
  return "float";
}

std::string header(VoxelType type, bool is_big, const std::string& more) {
  return "NRRD0004\n# a comment: with a colon\ntype: " + nrrd_type(type) +
         "\ndimension: 3\nsizes: 5 4 3\nendian: " + (is_big ? "big" : "little") + "\n" + more;
}

std::string short_header(const std::string& more) {
  return header(VoxelType::int16, false, "encoding: raw\n" + more);
}

class NrrdFiles : public testing::TestWithParam<std::tuple<VoxelType, bool, bool, std::string>> {};

TEST_P(NrrdFiles, HoldTheirSamples) {
  const auto& [type, is_big, is_detached, encoding] = GetParam();
  const Scratch folder;
  const auto samples = sample_text(type, kSamples, is_big);
  const auto data = encoding == "raw" ? samples : deflated(samples);
  const auto text = header(type, is_big, "encoding: " + encoding + "\n");
  std::filesystem::path path;
  if (is_detached) {
    folder.write("samples of it.raw", data);
    path = folder.write("scan.nhdr", text + "data file: samples of it.raw\n");
  } else {
    path = folder.write("scan.nrrd", text + "\n" + data);
  }
  const auto volume = read_volume(path);
  ASSERT_TRUE(volume.ok()) << volume.error().message;
  EXPECT_EQ(volume->size(), Size3(5, 4, 3));
  EXPECT_EQ(volume->type(), type);
  EXPECT_EQ(text_of_samples(*volume), sample_text(type, kSamples, false));
  expect_matrix(volume->world_from_voxel(), glm::dmat4(1.0));
}

INSTANTIATE_TEST_SUITE_P(All, NrrdFiles,
                         testing::Combine(testing::ValuesIn(kAllTypes), testing::Bool(),
                                          testing::Bool(),
                                          testing::Values("raw", "gzip", "gz", "GZIP")));

TEST(Nrrd, EveryNameOfATypeIsKnown) {
  const std::vector<std::pair<VoxelType, std::vector<std::string>>> names = {
      {VoxelType::int8, {"signed char", "int8", "int8_t"}},
      {VoxelType::uint8, {"uchar", "unsigned char", "uint8", "uint8_t"}},
      {VoxelType::int16,
       {"short", "short int", "signed short", "signed short int", "int16", "int16_t"}},
      {VoxelType::uint16, {"ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"}},
      {VoxelType::float32, {"float", "FLOAT"}}};
  const Scratch folder;
  for (const auto& [type, spellings] : names) {
    for (const auto& name : spellings) {
      const auto path = folder.write(
          "scan.nrrd", "NRRD0001\ntype: " + name +
                           "\ndimension: 3\nsizes: 5 4 3\nendian: little\nencoding: raw\n\n" +
                           sample_text(type, kSamples, false));
      const auto volume = read_volume(path);
      ASSERT_TRUE(volume.ok()) << volume.error().message;
      EXPECT_EQ(volume->type(), type) << name;
    }
  }
}

TEST(Nrrd, UnsupportedTypesAreRefusedByName) {
  const Scratch folder;
  for (const std::string name : {"int", "uint32_t", "double", "longlong", "block", "char"}) {
    const auto text = replaced(short_header(""), "type: short", "type: " + name);
    expect_refused(folder.write("scan.nrrd", text + "\n" + std::string(999, 'x')),
                   {":3: ", "8- or 16-bit integer", "32-bit float", "\"" + name + "\""});
  }
}

TEST(Nrrd, VersionsOneToFiveWithEitherLineEnd) {
  const Scratch folder;
  const auto samples = sample_text(VoxelType::int16, kSamples, false);
  for (char version = '1'; version <= '5'; ++version) {
    auto text = replaced(short_header("\n"), "NRRD0004", std::string("NRRD000") + version);
    ASSERT_TRUE(read_volume(folder.write("unix.nrrd", text + samples)).ok()) << version;
    for (std::size_t at = 0; (at = text.find('\n', at)) != text.npos; at += 2) {
      text.replace(at, 1, "\r\n");
    }
    const auto volume = read_volume(folder.write("dos.nrrd", text + samples));
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(text_of_samples(*volume), samples);
  }
  expect_refused(folder.write("new.nrrd", replaced(short_header("\n"), "NRRD0004", "NRRD0006")),
                 {":1: expected NRRD0001 to NRRD0005, got \"NRRD0006\""});
}

TEST(Nrrd, OtherFieldsAndKeyValuePairsAreAllowed) {
  const Scratch folder;
  const auto path = folder.write(
      "scan.nrrd", short_header("content: a: b\nkinds: domain domain domain\ncenterings: cell cell "
                                "cell\nspace units: \"mm\" \"mm\" \"mm\"\nOld Min: -3\nblocksize: "
                                "4\nthicknesses: 1 1 NaN\nmeasurement frame: (1,0,0) (0,1,0) "
                                "(0,0,1)\nmy key:=value: with := x\nmodality:=CT\n\n") +
                       sample_text(VoxelType::int16, kSamples, false));
  EXPECT_TRUE(read_volume(path).ok()) << read_volume(path).error().message;
}

TEST(Nrrd, OneByteSamplesNeedNoEndian) {
  const Scratch folder;
  const auto text =
      replaced(header(VoxelType::uint8, false, "encoding: raw\n\n"), "endian: little\n", "");
  EXPECT_TRUE(read_volume(folder.write("scan.nrrd", text + std::string(kSamples, 'x'))).ok());
  const auto two_bytes = replaced(short_header("\n"), "endian: little\n", "");
  expect_refused(folder.write("two.nrrd", two_bytes + std::string(2 * kSamples, 'x')),
                 {"the field \"endian\""});
}

glm::dmat4 world_of(const std::string& fields) {
  const Scratch folder;
  const auto volume = read_volume(folder.write(
      "scan.nrrd", short_header(fields + "\n") + sample_text(VoxelType::int16, kSamples, false)));
  EXPECT_TRUE(volume.ok()) << volume.error().message;
  return volume.ok() ? volume->world_from_voxel() : glm::dmat4(0.0);
}

TEST(NrrdOrientation, SpacingsAlonePutTheFirstVoxelAtZero) {
  expect_matrix(world_of("spacings: 0.5 2 3.25\n"), axis_aligned({0.5, 2, 3.25}));
  expect_matrix(world_of("spacings: 1e-2 -2 +3\n"), axis_aligned({0.01, -2, 3}));
}

TEST(NrrdOrientation, LpsIsTakenAsItIs) {
  const glm::dmat4 expected(0, 2, 0, 0,  // the first axis runs along +y
                            -1, 0, 0, 0, 0, 0.5, 3, 0, 10, -20, 30.5, 1);
  const std::string vectors =
      "space directions: (0,2,0) (-1,0,0) (0,0.5,3)\nspace origin: (10,-20,30.5)\n";
  for (const std::string space : {"left-posterior-superior", "LPS", "Left-Posterior-Superior",
                                  "3D-right-handed", "3D-left-handed", "scanner-xyz"}) {
    expect_matrix(world_of("space: " + space + "\n" + vectors), expected);
  }
  expect_matrix(world_of("space dimension: 3\n" + vectors), expected);
  expect_matrix(world_of("space: LPS\nspace directions: ( 0, 2 ,0)(-1,0,0)  (0,5e-1,3)\n"
                         "space origin: (10, -20, 30.5)\n"),
                expected);
}

TEST(NrrdOrientation, RasAndLasAreTurnedToLps) {
  const std::string vectors =
      "space directions: (2,3,4) (-1,0.5,0) (0,1,3)\nspace origin: (10,-20,30)\n";
  const glm::dmat4 from_ras(-2, -3, 4, 0, 1, -0.5, 0, 0, 0, -1, 3, 0, -10, 20, 30, 1);
  const glm::dmat4 from_las(2, -3, 4, 0, -1, -0.5, 0, 0, 0, -1, 3, 0, 10, 20, 30, 1);
  for (const std::string space : {"right-anterior-superior", "RAS", "ras"}) {
    expect_matrix(world_of("space: " + space + "\n" + vectors), from_ras);
  }
  for (const std::string space : {"left-anterior-superior", "LAS"}) {
    expect_matrix(world_of("space: " + space + "\n" + vectors), from_las);
  }
}

TEST(NrrdOrientation, WhatCannotBeIsRefused) {
  const Scratch folder;
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"spacings: 1 NaN 1", "spacings"},
      {"spacings: 1 inf 1", "spacings"},
      {"spacings: 1 0 1", "spacings"},
      {"spacings: 1 1", "spacings"},
      {"spacings: 1 1 1 1", "spacings"},
      {"spacings: 1 1 one", "spacings"},
      {"spacings: 1e-320 1e-320 1e-320", "spacings"},
      {"spacings: 1e200 1e200 1e200", "spacings"},
      {"space directions: (1,0,0) (0,1,0) (1,1,0)", "singular"},
      {"space directions: (1,0,0) (0,1,0) (0,0,0)", "singular"},
      {"space directions: (1,0,0) (0,1,0) (0,0,nan)", "three vectors"},
      {"space directions: (1,0,0) (0,1,0)", "three vectors"},
      {"space directions: (1,0,0) (0,1,0) none", "three vectors"},
      {"space directions: (1,0) (0,1) (0,0)", "three vectors"},
      {"space directions: (1,0,0) (0,1,0) (0,0,1", "three vectors"},
      {"space directions: (1,,0) (0,1,0) (0,0,1)", "three vectors"},
      {"space origin: (1,2,inf)", "a point"},
      {"space origin: 1 2 3", "a point"},
      {"space: left-posterior-superior-time", "a space of 3 dimensions"},
      {"space: mars", "a space of 3 dimensions"},
      {"space dimension: 4", "a space of 3 dimensions"}};
  for (const auto& [field, expected] : cases) {
    expect_refused(folder.write("scan.nrrd", short_header(field + "\n\n") + std::string(120, 'x')),
                   {":8: ", expected});
  }
}

TEST(NrrdSkips, LinesThenBytes) {
  const Scratch folder;
  const auto samples = sample_text(VoxelType::int16, kSamples, false);
  folder.write("data", "one\ntwo\n\xff\xff\xff" + samples + "behind");
  for (const std::string fields : {"line skip: 2\nbyte skip: 3\n", "lineskip: 2\nbyteskip: 3\n"}) {
    const auto volume =
        read_volume(folder.write("scan.nhdr", short_header(fields + "data file: data\n")));
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(text_of_samples(*volume), samples);
  }
  const auto attached = read_volume(folder.write(
      "scan.nrrd", short_header("line skip: 1\nbyte skip: 2\n\n") + "line\n??" + samples));
  ASSERT_TRUE(attached.ok()) << attached.error().message;
  EXPECT_EQ(text_of_samples(*attached), samples);
}

TEST(NrrdSkips, MinusOneTakesTheLastBytes) {
  const Scratch folder;
  const auto samples = sample_text(VoxelType::int16, kSamples, false);
  folder.write("data", "a header of unknown length" + samples);
  const auto volume =
      read_volume(folder.write("scan.nhdr", short_header("byte skip: -1\ndata file: data\n")));
  ASSERT_TRUE(volume.ok()) << volume.error().message;
  EXPECT_EQ(text_of_samples(*volume), samples);
  folder.write("data", samples.substr(1));
  const auto short_by_one =
      read_volume(folder.write("short.nhdr", short_header("byte skip: -1\ndata file: data\n")));
  ASSERT_FALSE(short_by_one.ok());
  EXPECT_EQ(short_by_one.error().kind, ErrorKind::bad_input);
}

TEST(NrrdSkips, BytesOfGzipAreSkippedDecompressedAndLinesBefore) {
  const Scratch folder;
  const auto samples = sample_text(VoxelType::uint16, kSamples, true);
  const auto text =
      header(VoxelType::uint16, true, "encoding: gzip\nline skip: 1\nbyte skip: 70000\n\n");
  const auto volume = read_volume(
      folder.write("scan.nrrd", text + "line\n" + deflated(std::string(70000, 'x') + samples)));
  ASSERT_TRUE(volume.ok()) << volume.error().message;
  EXPECT_EQ(text_of_samples(*volume), sample_text(VoxelType::uint16, kSamples, false));
}

TEST(NrrdSkips, ThoseBeyondTheFileAreRefused) {
  const Scratch folder;
  const auto samples = sample_text(VoxelType::int16, kSamples, false);
  for (const std::string field :
       {"byte skip: 9999", "byte skip: -2", "byte skip: x", "byte skip: 9223372036854775807",
        "byte skip: 99999999999999999999", "line skip: 1000", "line skip: -1"}) {
    expect_refused(folder.write("scan.nrrd", short_header(field + "\n\n") + samples), {":8: "});
  }
  const auto gzip = header(VoxelType::int16, false, "encoding: gzip\nbyte skip: -1\n\n");
  expect_refused(folder.write("gzip.nrrd", gzip + deflated(samples)), {":8: ", "gzip"});
  const auto beyond =
      header(VoxelType::int16, false, "encoding: gzip\nbyte skip: 9223372036854775807\n\n");
  expect_refused(folder.write("beyond.nrrd", beyond + deflated(samples)), {"byte offset"});
}

TEST(NrrdGzip, SeveralMembersReadAsOne) {
  const Scratch folder;
  const auto samples = sample_text(VoxelType::int16, kSamples, false);
  const auto text = header(VoxelType::int16, false, "encoding: gzip\n\n");
  const auto volume =
      read_volume(folder.write("scan.nrrd", text + deflated(samples.substr(0, 31)) + deflated("") +
                                                deflated(samples.substr(31))));
  ASSERT_TRUE(volume.ok()) << volume.error().message;
  EXPECT_EQ(text_of_samples(*volume), samples);
}

TEST(NrrdGzip, CorruptOrShortStreamsAreRefused) {
  const Scratch folder;
  const auto text = header(VoxelType::int16, false, "encoding: gzip\n\n");
  const auto samples = sample_text(VoxelType::int16, kSamples, false);
  const auto good = deflated(samples);
  for (std::size_t length = 0; length < good.size(); ++length) {
    expect_refused(folder.write("cut.nrrd", text + good.substr(0, length)), {"byte offset"});
  }
  auto wrong_sum = good;
  wrong_sum[good.size() - 6] ^= 1;
  expect_refused(folder.write("sum.nrrd", text + wrong_sum), {"byte offset", "corrupt"});
  expect_refused(folder.write("noise.nrrd", text + std::string(500, '\x55')),
                 {"byte offset", "corrupt"});
  expect_refused(folder.write("few.nrrd", text + deflated(samples.substr(0, 100))),
                 {"byte offset", "20 bytes are missing"});
}

TEST(NrrdHeader, WhatIsMissingOrWrongIsRefused) {
  const Scratch folder;
  const auto good = short_header("\n");
  const std::string data(2 * kSamples, 'x');
  for (const std::string line :
       {"type: short\n", "dimension: 3\n", "sizes: 5 4 3\n", "encoding: raw\n"}) {
    expect_refused(folder.write("scan.nrrd", replaced(good, line, "") + data),
                   {"\"" + line.substr(0, line.find(':')) + "\""});
  }
  const std::vector<std::tuple<std::string, std::string, std::string>> cases = {
      {"dimension: 3", "dimension: 4", "3 dimensions"},
      {"dimension: 3", "dimension: 2", "3 dimensions"},
      {"sizes: 5 4 3", "sizes: 5 4", "three sizes"},
      {"sizes: 5 4 3", "sizes: 5 4 3 1", "three sizes"},
      {"sizes: 5 4 3", "sizes: 5 4 0", "three sizes"},
      {"sizes: 5 4 3", "sizes: -5 -4 3", "three sizes"},
      {"sizes: 5 4 3", "sizes: 5 4 3.0", "three sizes"},
      {"sizes: 5 4 3", "sizes: 4294967297 4 3", "three sizes"},
      {"sizes: 5 4 3", "sizes: 2147483647 2147483647 2147483647", "three sizes"},
      {"endian: little", "endian: middle", "\"little\" or \"big\""},
      {"encoding: raw", "encoding: ascii", "encoding raw or gzip"},
      {"encoding: raw", "encoding: hex", "encoding raw or gzip"},
      {"encoding: raw", "encoding: bzip2", "encoding raw or gzip"},
      {"encoding: raw", "encoding: raw\nkinds: vector domain domain", "three spatial axes"},
      {"encoding: raw", "encoding: raw\nencoding: gzip", "each field once"},
      {"encoding: raw", "encoding: raw\nspce: LPS", "a field that NRRD has"},
      {"encoding: raw", "encoding: raw\nno colon here", "field: value"},
      {"encoding: raw", "encoding: raw\ndata file: LIST\na.raw", "one data file"},
      {"encoding: raw", "encoding: raw\ndata file: slice%03d.raw 0 2 1", "one data file"}};
  for (const auto& [from, to, expected] : cases) {
    expect_refused(folder.write("scan.nrrd", replaced(good, from, to) + data), {expected});
  }
}

TEST(NrrdHeader, DetachedDataMustBeThere) {
  const Scratch folder;
  expect_refused(folder.write("scan.nhdr", short_header("data file: gone.raw\n")),
                 {":8: ", "gone.raw"});
  expect_refused(folder.write("self.nhdr", short_header("")), {"data file"});
  expect_refused(folder.write("dir.nhdr", short_header("data file: .\n")),
                 {":8: ", "regular file"});
}

}  // namespace
}  // namespace maille
