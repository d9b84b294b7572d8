#include "deform/plane_store.h"

#include <atomic>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "deform/displacement_plane.h"
#include "deform/plane_codec.h"

namespace maille {
namespace {

constexpr VoxelBox kBox{{0, 0, 0}, {kBrickEdge, kBrickEdge, kBrickEdge}};
constexpr std::int64_t kPlaneBytes = kBrickVoxels * 2;

std::vector<std::int32_t> values_of(unsigned seed, bool wide) {
  std::mt19937 random(seed);
  std::vector<std::int32_t> u(kBrickVoxels);
  for (auto& value : u) {
    value = static_cast<std::int32_t>(random() % (wide ? 2000000u : 5000u)) - 1000;
  }
  return u;
}

DisplacementPlane::Pointer paged_plane(const std::shared_ptr<PlaneStore>& store, unsigned seed,
                                       bool wide = false) {
  auto plane = DisplacementPlane::encode(kBox, values_of(seed, wide).data());
  plane->page_through(store);
  return plane;
}

bool holds(const DisplacementPlane& plane, const std::vector<std::int32_t>& u) {
  for (int row = 0; row < kBrickEdge * kBrickEdge; ++row) {
    std::int32_t read[kBrickEdge];
    plane.read_row(row * kBrickEdge, kBrickEdge, read);
    if (!std::equal(read, read + kBrickEdge, &u[static_cast<std::size_t>(row) * kBrickEdge])) {
      return false;
    }
  }
  return plane.at(12345) == u[12345];
}

TEST(PlaneCodec, BringsEveryBitBack) {
  for (const int value_bytes : {2, 4}) {
    std::mt19937 random(3);
    std::vector<std::byte> values(static_cast<std::size_t>(kBrickVoxels * value_bytes));
    for (auto& b : values) b = static_cast<std::byte>(random());
    std::vector<std::byte> back(values.size());
    ASSERT_TRUE(unpack_plane(pack_plane(values, value_bytes), back, value_bytes));
    EXPECT_EQ(back, values);
    EXPECT_FALSE(unpack_plane(pack_plane(values, value_bytes), std::span(back).first(100), 2));
  }
}

TEST(PlaneCodec, SmoothDisplacementsTakeAFewPercent) {
  std::vector<std::uint16_t> values(kBrickVoxels);
  for (std::size_t e = 0; e < values.size(); ++e) {
    const int distance =
        std::abs(int(e % 32) - 16) + std::abs(int(e / 32 % 32) - 16) + std::abs(int(e / 1024) - 16);
    values[e] = static_cast<std::uint16_t>(std::max(0, 12800 - 128 * distance));
  }
  const auto packed = pack_plane(std::as_bytes(std::span(values)), 2);
  EXPECT_LT(packed.size(), 65536u / 20);
}

TEST(PlaneStore, HoldsTheBudgetAndBringsPlanesBack) {
  const auto store = std::make_shared<PlaneStore>(4 * kPlaneBytes);
  std::vector<DisplacementPlane::Pointer> planes;
  for (unsigned n = 0; n < 20; ++n) {
    planes.push_back(paged_plane(store, n, n % 5 == 0));
    store->hold_budget();
    EXPECT_LE(store->counters().bytes_in_memory, 4 * kPlaneBytes);
  }
  EXPECT_GE(store->counters().planes_written, 16);
  for (unsigned n = 20; n-- > 0;) {
    EXPECT_TRUE(holds(*planes[n], values_of(n, n % 5 == 0))) << n;
    EXPECT_LE(store->counters().bytes_in_memory, 4 * kPlaneBytes);
  }
  EXPECT_GE(store->counters().planes_read, 16);
  // What is in the file already is not written twice.
  const auto written = store->counters().planes_written;
  EXPECT_LE(written, 20);
  for (unsigned n = 0; n < 20; ++n) EXPECT_TRUE(holds(*planes[n], values_of(n, n % 5 == 0)));
  EXPECT_LE(store->counters().planes_written, 20);
}

TEST(PlaneStore, WhatNobodyWantsGoesFirst) {
  const auto store = std::make_shared<PlaneStore>(100 * kPlaneBytes);
  std::vector<DisplacementPlane::Pointer> planes;
  for (unsigned n = 0; n < 3; ++n) planes.push_back(paged_plane(store, n));
  store->set_wanted(std::vector<const PagedArray*>{planes[2]->paged()}, false);
  EXPECT_TRUE(holds(*planes[2], values_of(2, false)));
  for (unsigned n = 0; n < 85; ++n) planes.push_back(paged_plane(store, n));
  for (unsigned n = 0; n < 13; ++n) planes.push_back(paged_plane(store, n));
  store->hold_budget();
  EXPECT_EQ(planes[2]->paged()->bytes_in_memory(), 0);
}

TEST(PlaneStore, ForgetsPlanesThatAreGone) {
  const auto store = std::make_shared<PlaneStore>(2 * kPlaneBytes);
  for (unsigned n = 0; n < 200; ++n) {
    std::vector<DisplacementPlane::Pointer> planes;
    for (unsigned m = 0; m < 6; ++m) planes.push_back(paged_plane(store, n + m));
    store->hold_budget();
  }
  EXPECT_EQ(store->counters().bytes_in_memory, 0);
  // Room of the dead ones was used again.
  EXPECT_LT(store->counters().scratch_file_bytes, 8 * kPlaneBytes);
}

TEST(PlaneStore, ManyReadersWhileOthersPutAside) {
  const auto store = std::make_shared<PlaneStore>(3 * kPlaneBytes);
  std::vector<DisplacementPlane::Pointer> planes;
  std::vector<std::vector<std::int32_t>> values;
  for (unsigned n = 0; n < 8; ++n) {
    values.push_back(values_of(n, false));
    planes.push_back(paged_plane(store, n));
  }
  std::atomic<int> wrong{0};
  std::vector<std::jthread> readers;
  for (unsigned r = 0; r < 4; ++r) {
    readers.emplace_back([&, r] {
      std::mt19937 random(r);
      for (int n = 0; n < 300; ++n) {
        const std::size_t p = random() % planes.size();
        for (int k = 0; k < 20; ++k) {
          const int row = static_cast<int>(random() % 1024);
          std::int32_t read[kBrickEdge];
          planes[p]->read_row(row * kBrickEdge, kBrickEdge, read);
          const auto* const expected = &values[p][static_cast<std::size_t>(row) * kBrickEdge];
          if (!std::equal(read, read + kBrickEdge, expected)) ++wrong;
        }
      }
    });
  }
  for (unsigned n = 0; n < 200; ++n) {
    static_cast<void>(paged_plane(store, n));
    store->hold_budget();
  }
  readers.clear();
  EXPECT_EQ(wrong, 0);
  EXPECT_LE(store->counters().peak_bytes_in_memory, (3 + 4) * kPlaneBytes);
}

}  // namespace
}  // namespace maille
