#include "core/aligned_array.h"

#include <atomic>
#include <cstdint>
#include <cstring>
#include <limits>
#include <new>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace maille {
namespace {

constexpr std::size_t kSmallBlock = std::size_t{64} << 10;
constexpr std::size_t kLargeBlock = std::size_t{128} << 10;

// Sanitizers are to find blocks that are used after they were freed: nothing is kept for them.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kKeeps = false;
#else
constexpr bool kKeeps = true;
#endif

template <class T>
bool on_a_cache_line(const AlignedArray<T>& array) {
  return reinterpret_cast<std::uintptr_t>(array.get()) % kCacheLine == 0;
}

TEST(AlignedArray, StartsOnACacheLineAndHoldsWhatIsWritten) {
  for (const std::size_t count : {1u, 3u, 31u, 32u, 1000u, 32767u, 32768u, 32769u, 65536u}) {
    std::vector<AlignedArray<std::uint16_t>> narrow;
    std::vector<AlignedArray<std::uint32_t>> wide;
    for (std::uint32_t n = 0; n < 5; ++n) {
      narrow.push_back(make_aligned_array<std::uint16_t>(count));
      wide.push_back(make_aligned_array<std::uint32_t>(count));
      EXPECT_TRUE(on_a_cache_line(narrow.back()));
      EXPECT_TRUE(on_a_cache_line(wide.back()));
      std::fill_n(narrow.back().get(), count, static_cast<std::uint16_t>(n));
      std::fill_n(wide.back().get(), count, n + 100);
    }
    for (std::uint32_t n = 0; n < 5; ++n) {
      for (std::size_t i = 0; i < count; ++i) {
        ASSERT_EQ(narrow[n][i], n);
        ASSERT_EQ(wide[n][i], n + 100);
      }
    }
  }
}

TEST(AlignedArray, FreedBricksAreTakenAgain) {
  for (const std::size_t bytes : {kSmallBlock, kLargeBlock}) {
    auto first = make_aligned_array<std::byte>(bytes);
    const void* const where = first.get();
    const std::size_t kept = kept_block_bytes();
    first.reset();
    EXPECT_EQ(kept_block_bytes(), kept + (kKeeps ? bytes : 0));
    const auto again = make_aligned_array<std::byte>(bytes);
    if (kKeeps) {
      EXPECT_EQ(again.get(), where);
    }
    EXPECT_EQ(kept_block_bytes(), kept);
  }
}

TEST(AlignedArray, OtherSizesAreNotKept) {
  const std::size_t kept = kept_block_bytes();
  for (const std::size_t bytes :
       {std::size_t{64}, kSmallBlock - 1, kSmallBlock + 64, 2 * kLargeBlock}) {
    make_aligned_array<std::byte>(bytes).reset();
    EXPECT_EQ(kept_block_bytes(), kept);
  }
}

TEST(AlignedArray, NoMoreThanTheBoundIsKept) {
  std::vector<AlignedArray<std::byte>> arrays;
  // Half as much again as may be kept, of both sizes.
  for (std::size_t bytes = 0; bytes < kMostKeptBytes + kMostKeptBytes / 2;
       bytes += kSmallBlock + kLargeBlock) {
    arrays.push_back(make_aligned_array<std::byte>(kSmallBlock));
    arrays.push_back(make_aligned_array<std::byte>(kLargeBlock));
  }
  const std::size_t taken = kept_block_bytes();
  EXPECT_LE(taken, kMostKeptBytes);
  for (auto& array : arrays) {
    array.reset();
    ASSERT_LE(kept_block_bytes(), kMostKeptBytes);
  }
  if (kKeeps) {
    EXPECT_GT(kept_block_bytes(), kMostKeptBytes - kLargeBlock);
  } else {
    EXPECT_EQ(kept_block_bytes(), 0u);
  }
}

TEST(AlignedArray, LargeOnesAreMappedAndGivenBack) {
  for (const std::size_t bytes :
       {kLargeBytes - 1, kLargeBytes, kLargeBytes + 1, 3 * kLargeBytes + 4097}) {
    std::vector<AlignedArray<std::uint8_t>> arrays;
    for (std::uint8_t n = 0; n < 40; ++n) {
      arrays.push_back(make_aligned_array<std::uint8_t>(bytes));
      EXPECT_TRUE(on_a_cache_line(arrays.back()));
      // One in three lives on beside the ones made after it.
      std::memset(arrays.back().get(), n, bytes);
      if (n % 3) arrays.back().reset();
    }
    for (std::uint8_t n = 0; n < 40; n = static_cast<std::uint8_t>(n + 3)) {
      EXPECT_EQ(arrays[n][0], n);
      EXPECT_EQ(arrays[n][bytes / 2], n);
      EXPECT_EQ(arrays[n][bytes - 1], n);
    }
  }
}

TEST(AlignedArray, WhatIsTooLargeIsThrown) {
  constexpr std::size_t kMost = std::numeric_limits<std::size_t>::max();
  const std::size_t kept = kept_block_bytes();
  // More bytes than there are numbers for, or than an object may have.
  EXPECT_THROW(static_cast<void>(make_aligned_array<std::uint32_t>(kMost / 2)), std::bad_alloc);
  EXPECT_THROW(static_cast<void>(make_aligned_array<std::uint16_t>(kMost / 2 + 2)), std::bad_alloc);
  EXPECT_THROW(static_cast<void>(make_aligned_array<std::byte>(kMost)), std::bad_alloc);
  // More than any machine has. Sanitizers end the program where the system would only refuse.
  if (kKeeps) {
    EXPECT_THROW(static_cast<void>(make_aligned_array<std::byte>(kMost / 4)), std::bad_alloc);
  }
  EXPECT_EQ(kept_block_bytes(), kept);
}

// No two arrays that live at once share memory, whoever made them and whoever frees them.
TEST(AlignedArray, ThreadsNeverShareABlock) {
  std::atomic<int> torn{0};
  const auto hammer = [&](int me) {
    std::vector<AlignedArray<std::uint16_t>> held;
    for (int n = 0; n < 400; ++n) {
      held.push_back(make_aligned_array<std::uint16_t>(n % 2 ? 32768 : 65536));
      const auto mark = static_cast<std::uint16_t>(me * 1000 + n % 1000);
      for (std::size_t i = 0; i < 32768; i += 64) held.back()[i] = mark;
      std::this_thread::yield();
      for (std::size_t i = 0; i < 32768; i += 64) torn += held.back()[i] != mark;
      if (held.size() == 4) held.erase(held.begin());
    }
    // The last ones are freed by another thread.
    return held;
  };
  std::vector<std::vector<AlignedArray<std::uint16_t>>> left(4);
  {
    std::vector<std::jthread> threads;
    for (int me = 0; me < 4; ++me) {
      threads.emplace_back([&, me] { left[static_cast<std::size_t>(me)] = hammer(me); });
    }
  }
  std::jthread([&] { left.clear(); }).join();
  EXPECT_EQ(torn, 0);
  EXPECT_LE(kept_block_bytes(), kMostKeptBytes);
}

}  // namespace
}  // namespace maille
