#include "core/parallel.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <new>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace maille {
namespace {

class Pool : public testing::TestWithParam<int> {};

TEST_P(Pool, CallsEachIndexOnce) {
  WorkerPool pool(GetParam());
  EXPECT_EQ(pool.thread_count(), GetParam());
  for (const std::int64_t count : {0, 1, 2, 7, 1000, 10000}) {
    std::vector<std::atomic<int>> calls(static_cast<std::size_t>(count));
    pool.for_each(count,
                  [&](std::int64_t index, int) { ++calls[static_cast<std::size_t>(index)]; });
    for (const auto& n : calls) ASSERT_EQ(n, 1) << count;
  }
}

TEST_P(Pool, WorkersNeverShareTheirNumberAtOnce) {
  WorkerPool pool(GetParam());
  std::vector<std::atomic<int>> inside(static_cast<std::size_t>(GetParam()));
  std::atomic<bool> is_shared{false};
  pool.for_each(2000, [&](std::int64_t, int worker) {
    if (worker < 0 || worker >= GetParam()) std::abort();
    auto& mine = inside[static_cast<std::size_t>(worker)];
    if (mine.fetch_add(1) != 0) is_shared = true;
    mine.fetch_sub(1);
  });
  EXPECT_FALSE(is_shared);
}

TEST_P(Pool, ManyShortLoopsReturnAndSeeTheirOwnBody) {
  WorkerPool pool(GetParam());
  for (int loop = 0; loop < 3000; ++loop) {
    std::atomic<int> sum{0};
    pool.for_each(5, [&](std::int64_t index, int) { sum += loop + static_cast<int>(index); });
    ASSERT_EQ(sum, 5 * loop + 10);
  }
}

TEST_P(Pool, LoopsOfSeveralThreadsWaitForOneAnother) {
  WorkerPool pool(GetParam());
  std::atomic<int> owner{-1};
  std::atomic<int> calls{0};
  std::atomic<bool> is_mixed{false};
  const auto caller = [&](int me) {
    for (int loop = 0; loop < 50; ++loop) {
      std::atomic<int> left{8};
      pool.for_each(8, [&](std::int64_t, int) {
        int nobody = -1;
        if (!owner.compare_exchange_strong(nobody, me) && nobody != me) is_mixed = true;
        ++calls;
        if (--left == 0) owner = -1;
      });
    }
  };
  { std::jthread one(caller, 1), two(caller, 2), three(caller, 3); }
  EXPECT_EQ(calls, 3 * 50 * 8);
  EXPECT_FALSE(is_mixed);
}

TEST_P(Pool, WhoAsksForOneLoopIsNotKeptOutByWhoLoopsOnAndOn) {
  WorkerPool pool(GetParam());
  std::atomic<bool> is_over{false};
  std::atomic<int> begun{0};
  std::jthread looper([&] {
    while (!is_over) {
      pool.for_each(4, [&](std::int64_t index, int) {
        if (index == 0) ++begun;
        std::this_thread::sleep_for(std::chrono::microseconds(200));
      });
    }
  });
  while (begun == 0) std::this_thread::yield();
  std::vector<int> overtaken;
  for (int i = 0; i < 21; ++i) {
    const int before = begun;
    pool.for_each(1, [&](std::int64_t, int) { overtaken.push_back(begun - before); });
  }
  is_over = true;
  // The median, since a caller may lose its core before it has asked.
  std::sort(overtaken.begin(), overtaken.end());
  EXPECT_LE(overtaken[10], 1);
}

TEST_P(Pool, AGuestUsesTheWorkersOfItsHost) {
  WorkerPool host(GetParam());
  const std::atomic<bool> give_up{false};
  WorkerPool guest(host, give_up);
  WorkerPool guest_of_guest(guest, give_up);
  EXPECT_EQ(guest.thread_count(), GetParam());
  EXPECT_EQ(guest_of_guest.thread_count(), GetParam());
  std::vector<std::atomic<int>> calls(1000);
  guest.for_each(1000, [&](std::int64_t index, int) { ++calls[static_cast<std::size_t>(index)]; });
  guest_of_guest.for_each(
      1000, [&](std::int64_t index, int) { ++calls[static_cast<std::size_t>(index)]; });
  for (const auto& n : calls) ASSERT_EQ(n, 2);
}

TEST_P(Pool, AGuestThatIsGivenUpHandsOutNoMore) {
  WorkerPool host(GetParam());
  std::atomic<bool> give_up{false};
  WorkerPool guest(host, give_up);
  std::atomic<int> begun_late{0};
  EXPECT_THROW(guest.for_each(1000000,
                              [&](std::int64_t index, int) {
                                if (give_up) ++begun_late;
                                if (index == 10) give_up = true;
                              }),
               Interrupted);
  // What each of the others had in hand when the flag went up.
  EXPECT_LE(begun_late, GetParam() - 1);
  int calls = 0;
  EXPECT_THROW(guest.for_each(5, [&](std::int64_t, int) { ++calls; }), Interrupted);
  EXPECT_THROW(guest.for_each(0, [&](std::int64_t, int) { ++calls; }), Interrupted);
  EXPECT_EQ(calls, 0);
  // The host's own loops, and other guests', mind nothing of it.
  const std::atomic<bool> go_on{false};
  WorkerPool other(host, go_on);
  std::atomic<int> others_calls{0};
  host.for_each(100, [&](std::int64_t, int) { ++others_calls; });
  other.for_each(100, [&](std::int64_t, int) { ++others_calls; });
  EXPECT_EQ(others_calls, 200);
}

TEST_P(Pool, WhoAsksIsServedWhenTheGuestIsGivenUp) {
  WorkerPool host(GetParam());
  std::atomic<bool> give_up{false};
  std::atomic<bool> begun{false};
  std::atomic<std::int64_t> done{0};
  constexpr std::int64_t kMany = std::int64_t{1} << 40;  // longer than anybody waits
  bool interrupted = false;
  {
    std::jthread slow([&] {
      WorkerPool guest(host, give_up);
      try {
        guest.for_each(kMany, [&](std::int64_t, int) {
          begun = true;
          ++done;
        });
      } catch (const Interrupted&) {
        interrupted = true;
      }
    });
    while (!begun) std::this_thread::yield();
    give_up = true;
    int mine = 0;
    host.for_each(1, [&](std::int64_t, int) { ++mine; });
    EXPECT_EQ(mine, 1);
  }
  EXPECT_TRUE(interrupted);
  EXPECT_LT(done, kMany);
}

INSTANTIATE_TEST_SUITE_P(Threads, Pool, testing::Values(1, 2, 8));

TEST(WorkerPool, ZeroAsksForOneAHardwareThread) {
  WorkerPool pool(0);
  EXPECT_EQ(pool.thread_count(),
            static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
}

TEST(WorkerPool, WhatALoopWroteIsSeenAfterIt) {
  WorkerPool pool(4);
  std::vector<int> plain(4096, 0);
  for (int loop = 1; loop <= 20; ++loop) {
    pool.for_each(4096, [&](std::int64_t i, int) { plain[static_cast<std::size_t>(i)] += loop; });
  }
  for (const int value : plain) ASSERT_EQ(value, 210);
}

TEST(WorkerPool, WhatABodyThrowsReachesTheCaller) {
  for (const int threads : {1, 2, 8}) {
    WorkerPool pool(threads);
    EXPECT_THROW(pool.for_each(1000,
                               [](std::int64_t index, int) {
                                 if (index == 17) throw std::bad_alloc();
                               }),
                 std::bad_alloc);
    std::atomic<int> calls = 0;
    pool.for_each(100, [&](std::int64_t, int) { ++calls; });
    EXPECT_EQ(calls, 100);
  }
}

}  // namespace
}  // namespace maille
