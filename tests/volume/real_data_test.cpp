// Scans that nobody here made, in ../shared/data beside the checkout. Without that folder these
// tests are skipped and say so; every format is also proven on files that the other tests write.
#include <cstdio>
#include <fstream>

#include <gtest/gtest.h>

#include "tests/volume/sample_files.h"
#include "volume/statistics.h"

namespace maille {
namespace {

std::filesystem::path data_folder() {
  return std::filesystem::path(MAILLE_SOURCE_DIR) / ".." / "shared" / "data";
}

#define SKIP_WITHOUT_DATA()                                                     \
  if (!std::filesystem::is_directory(data_folder())) {                          \
    GTEST_SKIP() << "no folder ../shared/data beside the checkout: real scans " \
                    "are not read";                                             \
  }                                                                             \
  static_assert(true)

std::string sha256_of(std::span<const std::byte> bytes) {
  const test::Scratch folder;
  folder.write("bytes", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  FILE* pipe = popen(("sha256sum " + (folder / "bytes").string()).c_str(), "r");
  char text[65] = {};
  const bool is_read = pipe && std::fread(text, 1, 64, pipe) == 64;
  if (pipe) pclose(pipe);
  return is_read ? text : "";
}

// The value of "voxel sha256 (…): VALUE" and its like.
std::string provenance(const std::string& name, const std::string& key) {
  std::ifstream file(data_folder() / (name + ".provenance.txt"));
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(key)) continue;
    return line.substr(line.rfind(": ") + 2);
  }
  return "";
}

struct Scan {
  std::string name;
  Size3 size;
  VoxelType type;
  glm::dmat4 world_from_voxel;
  double lowest, highest;
};

void PrintTo(const Scan& scan, std::ostream* out) { *out << scan.name; }

class RealScans : public testing::TestWithParam<Scan> {};

TEST_P(RealScans, DecodeToTheirChecksum) {
  SKIP_WITHOUT_DATA();
  const Scan& scan = GetParam();
  const auto volume = read_volume(data_folder() / scan.name);
  ASSERT_TRUE(volume.ok()) << volume.error().message;
  EXPECT_EQ(volume->size(), scan.size);
  EXPECT_EQ(volume->type(), scan.type);
  test::expect_matrix(volume->world_from_voxel(), scan.world_from_voxel);
  const auto expected = provenance(scan.name, "voxel sha256");
  ASSERT_EQ(expected.size(), 64u);
  EXPECT_EQ(sha256_of(volume->bytes()), expected);
  const auto statistics = statistics_of(*volume);
  EXPECT_EQ(statistics.lowest, scan.lowest);
  EXPECT_EQ(statistics.highest, scan.highest);
}

INSTANTIATE_TEST_SUITE_P(
    SharedData, RealScans,
    testing::Values(Scan{"vhf_head_ct_i16_gz.nrrd",
                         {512, 512, 234},
                         VoxelType::int16,
                         axis_aligned({1, 1, 1}, {0, 0, 1500}),
                         -1024,
                         3063},
                    Scan{"vhf_face_i16.mha",
                         {160, 160, 90},
                         VoxelType::int16,
                         axis_aligned({1, 1, 1}, {170, 120, 1560}),
                         -1024,
                         2233},
                    Scan{"vhf_head_u16.mhd",
                         {120, 120, 97},
                         VoxelType::uint16,
                         axis_aligned({2, 2, 2}, {130.5, 110.5, 1540.5}),
                         0,
                         3537},
                    Scan{"vhf_head_u8_rawenc.nrrd",
                         {120, 120, 97},
                         VoxelType::uint8,
                         axis_aligned({2, 2, 2}, {130.5, 110.5, 1540.5}),
                         0,
                         255},
                    Scan{"vhf_head_120x120x97_uint8.raw",
                         {120, 120, 97},
                         VoxelType::uint8,
                         glm::dmat4(1.0),
                         0,
                         255},
                    Scan{"prostate_phantom_u16_gz.nrrd",
                         {82, 67, 13},
                         VoxelType::uint16,
                         axis_aligned({-0.5, -0.5, 3}, {15.683382511138916, 76.535760879516602,
                                                        -52.776130676269538}),
                         0,
                         2017},
                    Scan{"lung_fixed_mask_u8_z.mha",
                         {115, 157, 129},
                         VoxelType::uint8,
                         axis_aligned({1.366, 1.366, 2.5}, {-153.827, -150.352, -1434.5}),
                         0,
                         1}),
    [](const auto& scan) {
      std::string name = scan.param.name;
      for (char& c : name) c = c == '.' ? '_' : c;
      return name;
    });

TEST(RealConformance, OneBallInThreeFiles) {
  SKIP_WITHOUT_DATA();
  for (const std::string name :
       {"BallBinary30x30x30.nrrd", "BallBinary30x30x30.nhdr", "BallBinary30x30x30_gz.nrrd"}) {
    const auto volume = read_volume(data_folder() / "conformance_nrrd" / name);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->size(), Size3(30, 30, 30));
    EXPECT_EQ(volume->type(), VoxelType::int16);
    EXPECT_EQ(sha256_of(volume->bytes()).substr(0, 16), "283a970d9df9586b") << name;
  }
}

TEST(RealConformance, LegalNrrdThatIsNoVolumeIsRefusedPolitely) {
  SKIP_WITHOUT_DATA();
  for (const std::string name : {"test1d_ascii.nrrd", "test2d_ascii.nrrd"}) {
    test::expect_refused(data_folder() / "conformance_nrrd" / name, {"3 dimensions"});
  }
}

TEST(RealBadInputs, EachIsRefusedSayingWhatIsWrong) {
  SKIP_WITHOUT_DATA();
  const auto folder = data_folder() / "bad_inputs";
  test::expect_refused(folder / "short_data.mha", {"byte offset", "4608000 bytes"});
  test::expect_refused(folder / "missing_raw.mhd", {":24: ", "not_there.raw"});
  test::expect_refused(folder / "trunc_stream.nii.gz", {".nii.gz"});
  test::expect_refused(folder / "trunc_stream.nrrd", {"byte offset 40000", "end of the file"});
  test::expect_refused(folder / "empty.nrrd", {":1: "});
  test::expect_refused(folder / "text_not_nrrd.nrrd", {":1: ", "NRRD0001"});
  test::expect_refused(folder / "wrong_dims_128x128x128_uint8.raw",
                       {"2097152 bytes", "got 1396800"});
}

}  // namespace
}  // namespace maille
