#include "core/scratch_file.h"

#include <csignal>
#include <cstdlib>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <sys/resource.h>

namespace maille {
namespace {

std::vector<std::byte> bytes_of(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::byte> bytes(count);
  for (auto& b : bytes) b = static_cast<std::byte>(random());
  return bytes;
}

std::vector<std::byte> read(const ScratchFile& file, const ScratchFile::Slot& slot) {
  std::vector<std::byte> bytes(static_cast<std::size_t>(slot.bytes));
  EXPECT_TRUE(file.read(slot, bytes).ok());
  return bytes;
}

TEST(ScratchFile, GivesBackWhatWasPutAside) {
  auto file = ScratchFile::create();
  ASSERT_TRUE(file.ok()) << file.error().message;
  std::vector<ScratchFile::Slot> slots;
  for (unsigned n = 0; n < 20; ++n) slots.push_back(*file->write(bytes_of(n * 700, n)));
  for (unsigned n = 0; n < 20; ++n) EXPECT_EQ(read(*file, slots[n]), bytes_of(n * 700, n));
}

TEST(ScratchFile, UsesFreedRoomBeforeItGrows) {
  auto file = ScratchFile::create();
  ASSERT_TRUE(file.ok());
  std::mt19937 random(7);
  std::vector<std::pair<ScratchFile::Slot, unsigned>> kept;
  for (unsigned n = 0; n < 10000; ++n) {
    if (kept.size() == 16) {
      const std::size_t i = random() % kept.size();
      file->free(kept[i].first);
      kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(i));
    }
    kept.emplace_back(*file->write(bytes_of(1 + random() % 3000, n)), n);
  }
  EXPECT_LT(file->size_bytes(), 16 * 3072 * 3);
  for (const auto& [slot, seed] : kept) {
    EXPECT_EQ(read(*file, slot), bytes_of(static_cast<std::size_t>(slot.bytes), seed));
  }
  for (const auto& [slot, seed] : kept) file->free(slot);
  EXPECT_EQ(file->size_bytes(), 0);
}

TEST(ScratchFile, AFullDiskIsAnErrorAndTakesNothing) {
  auto file = ScratchFile::create();
  ASSERT_TRUE(file.ok());
  const auto slot = file->write(bytes_of(1000, 1));
  ASSERT_TRUE(slot.ok());
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{4096, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  const auto too_much = file->write(bytes_of(10000, 2));
  setrlimit(RLIMIT_FSIZE, &before);
  ASSERT_FALSE(too_much.ok());
  EXPECT_EQ(too_much.error().kind, ErrorKind::file_system);
  EXPECT_NE(too_much.error().message.find("writing a scratch file failed"), std::string::npos);
  EXPECT_EQ(file->size_bytes(), 1024);
  EXPECT_EQ(read(*file, *slot), bytes_of(1000, 1));
}

TEST(ScratchFile, NoFolderForItIsAnError) {
  const char* const before = std::getenv("TMPDIR");
  const std::string kept = before ? before : "";
  setenv("TMPDIR", "/nowhere/at/all", 1);
  const auto file = ScratchFile::create();
  before ? setenv("TMPDIR", kept.c_str(), 1) : unsetenv("TMPDIR");
  ASSERT_FALSE(file.ok());
  EXPECT_EQ(file.error().kind, ErrorKind::file_system);
}

}  // namespace
}  // namespace maille
