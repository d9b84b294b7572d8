#include "core/mapped_file.h"

#include <algorithm>
#include <string_view>

#include <gtest/gtest.h>

#include "tests/core/scratch.h"

namespace maille {
namespace {

std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TEST(MappedFile, HoldsTheFilesBytes) {
  const test::Scratch folder;
  const auto file = MappedFile::open(folder.write("file", std::string("a\0b\n", 4)));
  ASSERT_TRUE(file.ok());
  EXPECT_EQ(as_text(file->bytes()), std::string_view("a\0b\n", 4));
}

TEST(MappedFile, OutlivesTheNameOfItsFile) {
  const test::Scratch folder;
  auto file = MappedFile::open(folder.write("file", "text"));
  ASSERT_TRUE(file.ok());
  std::filesystem::remove(folder / "file");
  const MappedFile moved = *std::move(file);
  EXPECT_EQ(as_text(moved.bytes()), "text");
}

TEST(MappedFile, AnEmptyFileHasNoBytes) {
  const test::Scratch folder;
  const auto file = MappedFile::open(folder.write("file", ""));
  ASSERT_TRUE(file.ok());
  EXPECT_TRUE(file->bytes().empty());
}

TEST(MappedFile, RefusesWhatIsNoFile) {
  const test::Scratch folder;
  for (const auto& path : {folder / "not there", folder.path()}) {
    const auto file = MappedFile::open(path);
    ASSERT_FALSE(file.ok()) << path;
    EXPECT_EQ(file.error().kind, ErrorKind::file_system);
    EXPECT_NE(file.error().message.find(path.string()), std::string::npos);
  }
}

}  // namespace
}  // namespace maille
