// Files that say what cannot be: refused in words, without a crash, a hang or memory to speak of.
#include <chrono>
#include <random>

#include <sys/resource.h>

#include <gtest/gtest.h>

#include "tests/volume/sample_files.h"

namespace maille {
namespace {

using namespace test;

std::int64_t peak_rss_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return std::int64_t{usage.ru_maxrss} * 1024;
}

const std::string kNrrd =
    "NRRD0004\ntype: short\ndimension: 3\nsizes: 5 4 3\nendian: little\nencoding: raw\n";
const std::string kMetaImage =
    "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
    "DimSize = 5 4 3\nElementType = MET_SHORT\nElementDataFile = LOCAL\n";

TEST(BadInput, EmptyFiles) {
  const Scratch folder;
  for (const std::string name : {"a.nrrd", "a.nhdr", "a.mha", "a.mhd", "a_1x1x1_uint8.raw"}) {
    expect_refused(folder.write(name, ""), {});
  }
}

TEST(BadInput, TextThatIsNoHeader) {
  const Scratch folder;
  for (const std::string name : {"a.nrrd", "a.nhdr", "a.mha", "a.mhd"}) {
    expect_refused(folder.write(name, "this is a text file\nof two lines\n"),
                   {":1: ", "\"this is a text file\""});
    expect_refused(folder.write(name, "\n\n\n"), {":1: "});
  }
}

// A terminal should not obey what a file puts into a message.
TEST(BadInput, WhatIsQuotedIsShortAndHarmless) {
  const Scratch folder;
  const auto path = folder.write("a.nrrd", "\x1b[31m\x07" + std::string(100000, 'x') + "\n");
  const auto volume = read_volume(path);
  ASSERT_FALSE(volume.ok());
  EXPECT_LT(volume.error().message.size(), path.string().size() + 200);
  for (const char c : volume.error().message) EXPECT_NE(c, '\x1b');
}

TEST(BadInput, OneFormatUnderAnothersEnding) {
  const Scratch folder;
  expect_refused(folder.write("a.mha", kNrrd + "\n" + std::string(120, 'x')), {":1: "});
  expect_refused(folder.write("a.nrrd", kMetaImage + std::string(120, 'x')), {":1: "});
  expect_refused(folder.write("a.nrrd", deflated(kNrrd)), {":1: "});
}

TEST(BadInput, HeadersWithoutEnoughData) {
  const Scratch folder;
  const auto wide = [](const std::string& text, const std::string& from) {
    return replaced(text, from, "160 160 90");
  };
  expect_refused(folder.write("a.mha", wide(kMetaImage, "5 4 3") + std::string(199430, 'x')),
                 {"byte offset", "4608000 bytes", "160x160x90 int16", "got 199430"});
  expect_refused(folder.write("a.nrrd", wide(kNrrd, "5 4 3") + "\n" + std::string(199430, 'x')),
                 {"byte offset", "4608000 bytes", "160x160x90 int16", "got 199430"});
  expect_refused(folder.write("cut.nrrd", kNrrd), {"byte offset", "got 0"});
}

// Just under 2^63 bytes: no overflow, but nothing vouches for them either.
TEST(BadInput, GiantSizes) {
  const Scratch folder;
  const std::string sizes = "2147483647 2147483647 1";
  expect_refused(folder.write("a.nrrd", replaced(kNrrd, "5 4 3", sizes) + "\nx"), {"got 1"});
  expect_refused(folder.write("a.mha", replaced(kMetaImage, "5 4 3", sizes) + "x"), {"got 1"});
  for (const std::string overflow : {"2147483647 2147483647 3", "2147483648 1 1",
                                     "18446744073709551616 1 1", "1 1 99999999999"}) {
    expect_refused(folder.write("a.nrrd", replaced(kNrrd, "5 4 3", overflow) + "\nx"), {":4: "});
    expect_refused(folder.write("a.mha", replaced(kMetaImage, "5 4 3", overflow) + "x"), {":5: "});
  }
}

// Few compressed bytes, many promised: refused before memory is asked for, and when a stream could
// hold what is promised but does not, no more memory is touched than it fills.
TEST(BadInput, GzipBombs) {
  const Scratch folder;
  const auto before = peak_rss_bytes();
  const auto start = std::chrono::steady_clock::now();
  const auto zeros = deflated(std::string(1 << 20, '\0'));
  const std::string gzip = replaced(kNrrd, "raw", "gzip");
  expect_refused(
      folder.write("far.nrrd", replaced(gzip, "5 4 3", "100000 100000 100000") + "\n" + zeros),
      {"compressed data that can hold", "at most"});
  expect_refused(
      folder.write("zlib.mha", replaced(replaced(kMetaImage, "5 4 3", "100000 100000 1000"),
                                        "NDims = 3", "NDims = 3\nCompressedData = True") +
                                   zeros),
      {"compressed data that can hold", "at most"});
  // 4 MiB of trailing noise make 4 GiB believable.
  expect_refused(folder.write("near.nrrd", replaced(gzip, "5 4 3", "1024 1024 2000") + "\n" +
                                               zeros + std::string(4 << 20, 'x')),
                 {"bytes are missing"});
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
#if !defined(__SANITIZE_ADDRESS__)
  EXPECT_LT(peak_rss_bytes() - before, 100 << 20);
#else
  (void)before;  // the sanitizer's allocator keeps what was freed
#endif
}

// A hundred thousand lines end as soon as they make no sense, and key/value pairs may be many.
TEST(BadInput, LongHeaders) {
  const Scratch folder;
  std::string pairs;
  for (int i = 0; i < 100000; ++i) pairs += "key" + std::to_string(i) + ":=value\n";
  const auto start = std::chrono::steady_clock::now();
  expect_refused(folder.write("a.nrrd", "NRRD0004\n" + pairs), {":100001: ", "\"type\""});
  EXPECT_TRUE(
      read_volume(folder.write("b.nrrd", kNrrd + pairs + "\n" + std::string(120, 'x'))).ok());
  expect_refused(folder.write("c.nrrd", kNrrd + std::string(20 << 20, 'x')), {":7: "});
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
}

// Whatever a few wrong bytes turn a good file into, it is read or refused in words.
class Mutations : public testing::TestWithParam<int> {};

TEST_P(Mutations, AreReadOrRefused) {
  const Scratch folder;
  const std::string data = sample_text(VoxelType::int16, 60, false);
  folder.write("data", data);
  folder.write("data.gz", deflated(data));
  const std::string world =
      "space: right-anterior-superior\nspace directions: (1,0,0) (0,2,0) (0,0,3.5)\n"
      "space origin: (1e3,-2,0.5)\n";
  const std::string met_world =
      "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 1 2 3\nElementSpacing = 1 2 0.5\nNDims = 3";
  const std::vector<std::pair<std::string, std::string>> good = {
      {"a.nrrd", kNrrd + world + "\n" + data},
      {"b.nrrd",
       replaced(kNrrd, "raw", "gzip") + "spacings: 1 2 3\nbyte skip: 0\n\n" + deflated(data)},
      {"c.nhdr", kNrrd + world + "line skip: 0\nbyte skip: -1\ndata file: data\n"},
      {"d.nhdr", replaced(kNrrd, "raw", "gz") + "data file: data.gz\n"},
      {"e.mha", replaced(kMetaImage, "NDims = 3", met_world) + data},
      {"f.mha",
       replaced(kMetaImage, "NDims = 3", "NDims = 3\nCompressedData = True") + deflated(data, 15)},
      {"g.mhd", replaced(kMetaImage, "LOCAL", "data")}};
  std::mt19937 random(static_cast<std::uint32_t>(GetParam()));
  const auto below = [&](std::size_t n) {
    return random() % n;
  };  // plain, so that it is repeatable
  int read = 0, refused = 0;
  for (int round = 0; round < 500; ++round) {
    const auto& [name, text] = good[below(good.size())];
    std::string bytes = text;
    for (std::size_t edit = 0, edits = 1 + below(4); edit < edits; ++edit) {
      const std::size_t at = below(bytes.size());
      switch (below(6)) {
        case 0: bytes[at] = static_cast<char>(random()); break;
        case 1: bytes[at] ^= static_cast<char>(1 << below(8)); break;
        case 2: bytes.erase(at, 1 + below(8)); break;
        case 3: bytes.insert(at, bytes.substr(below(bytes.size()), below(20))); break;
        case 4: bytes[at] = "0123456789-.:= \n"[below(16)]; break;
        default: bytes.resize(at + 1); break;
      }
      if (bytes.empty()) bytes = "x";
    }
    const auto path = folder.write(name, bytes);
    const auto volume = read_volume(path);
    if (volume.ok()) {
      ++read;
      ASSERT_EQ(volume->bytes().size(), static_cast<std::size_t>(voxel_count(volume->size())) *
                                            bytes_per_voxel(volume->type()));
      ASSERT_TRUE(glm::determinant(volume->world_from_voxel()) != 0);
      volatile double last = volume->value_at(volume->size() - 1);
      (void)last;
    } else {
      ++refused;
      ASSERT_EQ(volume.error().kind, ErrorKind::bad_input) << volume.error().message;
      ASSERT_NE(volume.error().message.find(folder.path().string()), std::string::npos);
      ASSERT_NE(volume.error().message.find("expected"), std::string::npos);
    }
  }
  EXPECT_GT(read, 0);
  EXPECT_GT(refused, 0);
}

INSTANTIATE_TEST_SUITE_P(Seeds, Mutations, testing::Range(1, 13));

}  // namespace
}  // namespace maille
