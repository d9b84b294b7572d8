#include "volume/volume_file.h"

#include <chrono>

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "tests/volume/sample_files.h"

namespace maille {
namespace {

using namespace test;

Volume volume_of(VoxelType type, Size3 size, const glm::dmat4& world_from_voxel) {
  const auto text = sample_text(type, static_cast<int>(voxel_count(size)), false);
  return with_voxel_type(type, [&]<class T>() {
    std::vector<T> samples(text.size() / sizeof(T));
    std::memcpy(samples.data(), text.data(), text.size());
    return Volume::of(size, type, world_from_voxel, std::move(samples));
  });
}

std::int64_t peak_rss_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return std::int64_t{usage.ru_maxrss} * 1024;
}

TEST(WriteVolume, RoundTripIsExact) {
  const glm::dmat4 straight = axis_aligned({0.1, 1.0 / 3.0, -7e-5}, {1e6, -0.1, 1.0 / 7.0});
  const Scratch folder;
  for (const auto type : kAllTypes) {
    for (const std::string name : {"out.nrrd", "out.mha", "OUT.NRRD", "Out.Mha"}) {
      const auto volume = volume_of(type, {7, 5, 3}, straight);
      ASSERT_TRUE(write_volume(folder / name, volume).ok());
      const auto back = read_volume(folder / name);
      ASSERT_TRUE(back.ok()) << back.error().message;
      EXPECT_EQ(back->size(), volume.size());
      EXPECT_EQ(back->type(), type);
      EXPECT_EQ(text_of_samples(*back), text_of_samples(volume));
      EXPECT_EQ(back->world_from_voxel(), straight) << name;
    }
  }
}

TEST(WriteVolume, KeepsObliqueAxes) {
  const glm::dmat4 oblique(0.36, 0.48, -0.8, 0, -0.8, 0.6, 0.1, 0, 0.96, 1.28, 1.2, 0, -5, 6.25, 7,
                           1);
  const Scratch folder;
  const auto volume = volume_of(VoxelType::int16, {4, 4, 4}, oblique);
  ASSERT_TRUE(write_volume(folder / "a.nrrd", volume).ok());
  ASSERT_TRUE(write_volume(folder / "a.mha", volume).ok());
  EXPECT_EQ(read_volume(folder / "a.nrrd")->world_from_voxel(), oblique);
  expect_matrix(read_volume(folder / "a.mha")->world_from_voxel(), oblique);
}

TEST(WriteVolume, SamplesStartAtAMultipleOf64BytesSoThatTheyCanBeMapped) {
  const Scratch folder;
  for (int n = 1; n < 70; ++n) {
    const auto volume = volume_of(VoxelType::float32, {n, 1, 1}, axis_aligned(glm::dvec3(1.0 / n)));
    for (const std::string name : {"a.nrrd", "a.mha"}) {
      ASSERT_TRUE(write_volume(folder / name, volume).ok());
      const auto text = bytes_of(folder / name);
      EXPECT_EQ((text.size() - volume.bytes().size()) % 64, 0u) << name << " " << n;
      EXPECT_EQ(text.substr(text.size() - volume.bytes().size()), text_of_samples(volume));
    }
  }
}

TEST(WriteVolume, OtherEndingsAreWrongUsageAndWriteNothing) {
  const Scratch folder;
  const auto volume = volume_of(VoxelType::uint8, {2, 2, 2}, glm::dmat4(1.0));
  for (const std::string name : {"a.mhd", "a.nhdr", "a.raw", "a.png", "a", "a.nrrd.gz"}) {
    const auto written = write_volume(folder / name, volume);
    ASSERT_FALSE(written.ok()) << name;
    EXPECT_EQ(written.error().kind, ErrorKind::usage);
    EXPECT_NE(written.error().message.find(".nrrd or .mha"), std::string::npos);
  }
  EXPECT_TRUE(folder.names().empty());
  const auto nowhere = write_volume(folder / "nowhere" / "a.nrrd", volume);
  ASSERT_FALSE(nowhere.ok());
  EXPECT_EQ(nowhere.error().kind, ErrorKind::file_system);
}

TEST(WriteVolume, ReplacesTheVeryFileThatItWasReadFrom) {
  const Scratch folder;
  ASSERT_TRUE(
      write_volume(folder / "a.nrrd", volume_of(VoxelType::int16, {9, 9, 9}, glm::dmat4(1.0)))
          .ok());
  const auto mapped = read_volume(folder / "a.nrrd");
  ASSERT_TRUE(mapped.ok());
  const auto before = text_of_samples(*mapped);
  ASSERT_TRUE(write_volume(folder / "a.nrrd", *mapped).ok());
  EXPECT_EQ(text_of_samples(*mapped), before);
  EXPECT_EQ(text_of_samples(*read_volume(folder / "a.nrrd")), before);
}

TEST(WriteVectorField, HoldsThreeFloatsAVoxel) {
  const Scratch folder;
  std::vector<glm::vec3> vectors;
  for (int i = 0; i < 24; ++i) vectors.emplace_back(i, -i, 0.1f * static_cast<float>(i));
  const std::string expected(reinterpret_cast<const char*>(vectors.data()), 24 * 12);
  const auto world = axis_aligned({2, 3, 5}, {-1, 0.5, 7});

  ASSERT_TRUE(write_vector_field(folder / "f.nrrd", {4, 3, 2}, world, vectors).ok());
  auto text = bytes_of(folder / "f.nrrd");
  for (const std::string line :
       {"NRRD0004\n", "\ntype: float\n", "\ndimension: 4\n", "\nsizes: 3 4 3 2\n",
        "\nkinds: vector domain domain domain\n", "\nspace: left-posterior-superior\n",
        "\nspace directions: none (2,0,0) (0,3,0) (0,0,5)\n", "\nspace origin: (-1,0.5,7)\n",
        "\nendian: little\n", "\nencoding: raw\n"}) {
    EXPECT_NE(text.find(line), std::string::npos) << line;
  }
  EXPECT_EQ(text.substr(text.find("\n\n") + 2), expected);

  ASSERT_TRUE(write_vector_field(folder / "f.mha", {4, 3, 2}, world, vectors).ok());
  text = bytes_of(folder / "f.mha");
  for (const std::string line :
       {"\nNDims = 3\n", "\nElementNumberOfChannels = 3\n", "\nElementType = MET_FLOAT\n",
        "\nDimSize = 4 3 2\n", "\nElementSpacing = 2 3 5\n", "\nOffset = -1 0.5 7\n",
        "\nTransformMatrix = 1 0 0 0 1 0 0 0 1\n"}) {
    EXPECT_NE(text.find(line), std::string::npos) << line;
  }
  const std::string last = "ElementDataFile = LOCAL\n";
  EXPECT_EQ(text.substr(text.find(last) + last.size()), expected);
}

TEST(ReadVolume, ChoosesByTheEndingInEitherCase) {
  const Scratch folder;
  folder.write("A_2x1x1_uint8.RAW", "ab");
  EXPECT_TRUE(read_volume(folder / "A_2x1x1_uint8.RAW").ok());
}

TEST(ReadVolume, OtherEndingsAreRefusedNamingThoseThatAreRead) {
  const Scratch folder;
  for (const std::string name : {"a.nii.gz", "a.dcm", "a", "a.", "a.nrrd.bak"}) {
    expect_refused(folder.write(name, "x"), {".nrrd, .nhdr, .mha, .mhd or .raw"});
  }
  expect_refused(folder / "a.nii.gz", {"\".nii.gz\""});
}

TEST(ReadVolume, AFileThatIsNotThereIsAFileSystemError) {
  const Scratch folder;
  std::filesystem::create_directory(folder / "folder.nrrd");
  for (const std::string name :
       {"a.nrrd", "a.nhdr", "a.mha", "a.mhd", "a_1x1x1_uint8.raw", "a.xyz", "folder.nrrd"}) {
    const auto volume = read_volume(folder / name);
    ASSERT_FALSE(volume.ok()) << name;
    EXPECT_EQ(volume.error().kind, ErrorKind::file_system) << name;
    EXPECT_NE(volume.error().message.find((folder / name).string()), std::string::npos);
  }
}

// 1 GiB of holes: whoever copied it would show.
TEST(ReadVolume, LargeRawDataAreMappedAndNotCopied) {
  const Scratch folder;
  const auto raw = folder.write("a_1024x1024x512_int16.raw", "");
  std::filesystem::resize_file(raw, std::uintmax_t{1} << 30);
  const auto data = folder.write("detached", "");
  std::filesystem::resize_file(data, (std::uintmax_t{1} << 30) + 2);
  const auto nhdr = folder.write("a.nhdr",
                                 "NRRD0004\ntype: float\ndimension: 3\nsizes: 1024 512 512\n"
                                 "endian: little\nencoding: raw\ndata file: detached\n");
  for (const auto& path : {raw, nhdr}) {
    const auto before = peak_rss_bytes();
    const auto start = std::chrono::steady_clock::now();
    const auto volume = read_volume(path);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->value_at({1, 2, 3}), 0.0);
    EXPECT_EQ(volume->value_at(volume->size() - 1), 0.0);
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(1));
    EXPECT_LT(peak_rss_bytes() - before, 50 << 20);
  }
}

// A writer puts padding; other files do not, and their samples may start at an odd byte.
TEST(ReadVolume, UnalignedSamplesAreDecodedInsteadOfMapped) {
  const Scratch folder;
  const auto samples = sample_text(VoxelType::float32, 8, false);
  for (int odd = 0; odd < 8; ++odd) {
    const auto path =
        folder.write("a.nrrd",
                     "NRRD0004\ntype: float\ndimension: 3\nsizes: 2 2 2\nendian: "
                     "little\nencoding: raw\n#" +
                         std::string(static_cast<std::size_t>(odd), ' ') + "\n\n" + samples);
    const auto volume = read_volume(path);
    ASSERT_TRUE(volume.ok());
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(volume->bytes().data()) % alignof(float), 0u);
    EXPECT_EQ(text_of_samples(*volume), samples);
  }
}

}  // namespace
}  // namespace maille
