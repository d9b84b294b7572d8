#include "core/atomic_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "tests/core/scratch.h"

namespace maille {
namespace {

using test::bytes_of;
using test::Scratch;

std::span<const std::byte> as_bytes(std::string_view text) {
  return std::as_bytes(std::span(text));
}

TEST(AtomicFile, TakesTheNameOnCommit) {
  const Scratch folder;
  auto file = AtomicFile::create(folder / "new");
  ASSERT_TRUE(file.ok());
  ASSERT_TRUE(file->write(as_bytes("one ")).ok());
  EXPECT_FALSE(std::filesystem::exists(folder / "new"));
  ASSERT_TRUE(file->write(as_bytes("two")).ok());
  ASSERT_TRUE(file->commit().ok());
  EXPECT_EQ(bytes_of(folder / "new"), "one two");
  EXPECT_EQ(folder.names(), std::set<std::string>{"new"});
}

TEST(AtomicFile, WithoutCommitLeavesTheOldFileAndNothingElse) {
  const Scratch folder;
  folder.write("kept", "old");
  {
    auto file = AtomicFile::create(folder / "kept");
    ASSERT_TRUE(file.ok());
    ASSERT_TRUE(file->write(as_bytes("half of the n")).ok());
    EXPECT_EQ(bytes_of(folder / "kept"), "old");
    EXPECT_EQ(folder.names().size(), 2u);
    const AtomicFile moved = *std::move(file);
  }
  EXPECT_EQ(bytes_of(folder / "kept"), "old");
  EXPECT_EQ(folder.names(), std::set<std::string>{"kept"});
}

TEST(AtomicFile, ReplacesWholeFiles) {
  const Scratch folder;
  folder.write("file", "a much longer old text");
  ASSERT_TRUE(write_text_file(folder / "file", "new").ok());
  EXPECT_EQ(bytes_of(folder / "file"), "new");
}

TEST(AtomicFile, LeavesWhatIsNoFileAlone) {
  const Scratch folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  const auto refused = AtomicFile::create(folder / "pipe");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().kind, ErrorKind::file_system);
  EXPECT_TRUE(std::filesystem::is_fifo(folder / "pipe"));
}

TEST(AtomicFile, WritesThroughLinks) {
  const Scratch folder;
  folder.write("old", "old");
  std::filesystem::create_symlink("old", folder / "link");
  std::filesystem::create_symlink("new", folder / "link to nothing");
  ASSERT_TRUE(write_text_file(folder / "link", "one").ok());
  ASSERT_TRUE(write_text_file(folder / "link to nothing", "two").ok());
  EXPECT_EQ(bytes_of(folder / "old"), "one");
  EXPECT_EQ(bytes_of(folder / "new"), "two");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
}

TEST(AtomicFile, IsReadableAsAnyNewFile) {
  const Scratch folder;
  const mode_t mask = umask(022);
  ASSERT_TRUE(write_text_file(folder / "file", "text").ok());
  umask(mask);
  struct stat status {};
  ASSERT_EQ(stat((folder / "file").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0644u);
}

TEST(AtomicFile, WritesThroughALink) {
  const Scratch folder;
  folder.write("target", "old");
  std::filesystem::create_symlink("target", folder / "link");
  ASSERT_TRUE(write_text_file(folder / "link", "new").ok());
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(bytes_of(folder / "target"), "new");
}

void expect_file_system_error(const std::filesystem::path& path) {
  const auto written = write_text_file(path, "text");
  ASSERT_FALSE(written.ok()) << path;
  EXPECT_EQ(written.error().kind, ErrorKind::file_system);
  EXPECT_NE(written.error().message.find(path.string()), std::string::npos)
      << written.error().message;
}

TEST(AtomicFile, RefusesADirectory) {
  const Scratch folder;
  expect_file_system_error(folder.path());
  EXPECT_TRUE(folder.names().empty());
}

TEST(AtomicFile, RefusesAFolderThatIsNotThere) {
  const Scratch folder;
  expect_file_system_error(folder / "nowhere" / "file");
}

TEST(AtomicFile, RefusesAFolderThatMayNotBeWritten) {
  if (geteuid() == 0) {
    // root writes anywhere but below a file.
    const Scratch folder;
    folder.write("file", "");
    expect_file_system_error(folder / "file" / "below");
    return;
  }
  const Scratch folder;
  std::filesystem::permissions(
      folder.path(), std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  expect_file_system_error(folder / "file");
  std::filesystem::permissions(folder.path(), std::filesystem::perms::owner_all);
}

}  // namespace
}  // namespace maille
