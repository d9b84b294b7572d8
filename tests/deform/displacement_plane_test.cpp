// Displacement planes of every kind against the plain values they were made of.
#include "deform/displacement_plane.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "deform/lattice.h"
#include "tests/deform/lattices.h"

namespace maille {
namespace {

using testing::for_each_voxel;
using testing::lattice_of;

constexpr std::int64_t kSmall_bytes = 1024;  // what a plane takes beside its values, at most

// Values of the elements of a box; beyond it whatever the array has.
struct Values {
  VoxelBox box;
  std::vector<std::int32_t> u = std::vector<std::int32_t>(kBrickVoxels, 0);

  template <class F>
  Values(const VoxelBox& of, F&& value) : box(of) {
    for_each_voxel(box.size(), [&](VoxelIndex v) {
      u[static_cast<std::size_t>(element_in_brick(v))] = value(v);
    });
  }
};

void expect_same(const DisplacementPlane& plane, const Values& values) {
  std::int32_t lowest = std::numeric_limits<std::int32_t>::max();
  std::int32_t highest = std::numeric_limits<std::int32_t>::min();
  VoxelBox moved{values.box.hi, values.box.lo};
  std::int64_t differences = 0;
  for_each_voxel(values.box.size(), [&](VoxelIndex v) {
    const int e = element_in_brick(v);
    const std::int32_t u = values.u[static_cast<std::size_t>(e)];
    std::int32_t row[kBrickEdge];
    if (v.x == 0) {
      plane.read_row(e, kBrickEdge, row);
      const auto* expected = &values.u[static_cast<std::size_t>(e)];
      differences += !std::equal(row, row + values.box.size().x, expected);
    }
    differences += plane.at(e) != u;
    lowest = std::min(lowest, u);
    highest = std::max(highest, u);
    if (u == 0) return;
    moved = {glm::min(moved.lo, values.box.lo + v), glm::max(moved.hi, values.box.lo + v + 1)};
  });
  EXPECT_EQ(differences, 0);
  EXPECT_EQ(plane.lowest(), lowest);
  EXPECT_EQ(plane.highest(), highest);
  EXPECT_EQ(plane.moved(), moved);
}

constexpr VoxelBox kBoxes[] = {{{0, 0, 0}, {32, 32, 32}},
                               {{64, 32, 96}, {65, 33, 97}},
                               {{32, 0, 0}, {63, 5, 32}},
                               {{0, 96, 32}, {3, 128, 33}}};

TEST(DisplacementPlane, OfRestIsNone) {
  for (const VoxelBox& box : kBoxes) {
    EXPECT_EQ(DisplacementPlane::encode(box, Values(box, [](VoxelIndex) { return 0; }).u.data()),
              nullptr);
  }
  // What lies beyond the border is no displacement.
  std::vector<std::int32_t> u(kBrickVoxels, 12345);
  const VoxelBox box{{32, 0, 0}, {40, 9, 3}};
  for_each_voxel(box.size(),
                 [&](VoxelIndex v) { u[static_cast<std::size_t>(element_in_brick(v))] = 0; });
  EXPECT_EQ(DisplacementPlane::encode(box, u.data()), nullptr);
}

TEST(DisplacementPlane, OfOneValueIsOneNumber) {
  for (const VoxelBox& box : kBoxes) {
    for (const std::int32_t value : {1, -1, 65536, -512'000'000, 512'000'000}) {
      const Values values(box, [&](VoxelIndex) { return value; });
      const auto plane = DisplacementPlane::encode(box, values.u.data());
      ASSERT_NE(plane, nullptr);
      EXPECT_TRUE(plane->constant());
      EXPECT_EQ(plane->array_bytes(), 0);
      EXPECT_LT(plane->bytes(), kSmall_bytes);
      expect_same(*plane, values);
    }
  }
}

// Two bytes an element while values lie within 65535 of one another wherever that is, four beyond.
TEST(DisplacementPlane, IsAsWideAsItsRange) {
  std::mt19937 random(9);
  for (const VoxelBox& box : kBoxes) {
    if (voxel_count(box.size()) < 2) continue;
    for (const std::int32_t base : {0, -3, -65535, 400'000'000, -512'000'000}) {
      for (const std::int32_t range : {1, 700, 65535, 65536, 100'000'000}) {
        SCOPED_TRACE(::testing::Message() << base << " + " << range);
        Values values(box, [&](VoxelIndex) {
          return base + static_cast<std::int32_t>(random() % (static_cast<unsigned>(range) + 1));
        });
        values.u[0] = base;
        const VoxelIndex last = box.size() - 1;
        values.u[static_cast<std::size_t>(element_in_brick(last))] = base + range;
        const auto plane = DisplacementPlane::encode(box, values.u.data());
        ASSERT_NE(plane, nullptr);
        const std::int64_t bytes = (range > 65535 ? 4 : 2) * kBrickVoxels;
        EXPECT_FALSE(plane->constant());
        EXPECT_EQ(plane->array_bytes(), bytes);
        EXPECT_GE(plane->bytes(), bytes);
        EXPECT_LT(plane->bytes(), bytes + kSmall_bytes);
        expect_same(*plane, values);
      }
    }
  }
}

TEST(DisplacementPlane, KnowsTheBoxOfWhatHasMoved) {
  std::mt19937 random(10);
  for (int n = 0; n < 200; ++n) {
    const VoxelBox& box = kBoxes[static_cast<std::size_t>(n) % 4];
    Values values(box, [](VoxelIndex) { return 0; });
    for (int k = 1 + n % 3; k > 0; --k) {
      const VoxelIndex v(random() % static_cast<unsigned>(box.size().x),
                         random() % static_cast<unsigned>(box.size().y),
                         random() % static_cast<unsigned>(box.size().z));
      values.u[static_cast<std::size_t>(element_in_brick(v))] = n % 2 ? 1 : -(1 << (n % 20));
    }
    const auto plane = DisplacementPlane::encode(box, values.u.data());
    ASSERT_NE(plane, nullptr);
    expect_same(*plane, values);
  }
}

// Labels of a drag up or down, handed over as they are.
TEST(DisplacementPlane, AdoptsOffsetsUpwardsAndDownwards) {
  std::mt19937 random(11);
  for (const VoxelBox& box : kBoxes) {
    for (const std::int32_t step : {1, -1}) {
      for (const std::uint32_t most : {0u, 9u, 65535u}) {
        for (const std::int32_t base : {0, 70'000}) {
          auto offsets = make_aligned_array<std::uint16_t>(kBrickVoxels);
          std::fill_n(offsets.get(), kBrickVoxels, std::uint16_t{0});
          const Values values(box, [&](VoxelIndex v) {
            const auto offset = static_cast<std::uint16_t>(most ? random() % (most + 1) : 77);
            offsets[static_cast<std::size_t>(element_in_brick(v))] = offset;
            return base + step * offset;
          });
          // What encode() finds, adopt() is told.
          const auto encoded = DisplacementPlane::encode(box, values.u.data());
          ASSERT_NE(encoded, nullptr);
          const auto adopted = DisplacementPlane::adopt(
              {base, step, encoded->lowest(), encoded->highest(), encoded->moved()},
              std::move(offsets));
          EXPECT_EQ(adopted->constant(), encoded->constant());
          EXPECT_EQ(adopted->array_bytes(), encoded->array_bytes());
          expect_same(*adopted, values);
        }
      }
    }
  }
}

TEST(DisplacementPlane, ReadsTheSameThroughAStore) {
  std::mt19937 random(12);
  const VoxelBox box{{0, 0, 0}, {32, 20, 32}};
  // Room for one plane of 16 bits: every second read brings one back.
  const auto store = std::make_shared<PlaneStore>(2 * kBrickVoxels);
  std::vector<Values> values;
  std::vector<DisplacementPlane::Pointer> planes;
  for (const unsigned range : {500u, 65536u, 65535u}) {
    values.emplace_back(
        box, [&](VoxelIndex) { return static_cast<std::int32_t>(random() % range) - 250; });
    planes.push_back(DisplacementPlane::encode(box, values.back().u.data()));
    planes.back()->page_through(store);
    planes.back()->page_through(store);
  }
  auto offsets = make_aligned_array<std::uint16_t>(kBrickVoxels);
  std::fill_n(offsets.get(), kBrickVoxels, std::uint16_t{0});
  values.emplace_back(box, [&](VoxelIndex v) {
    const auto offset = static_cast<std::uint16_t>(random());
    offsets[static_cast<std::size_t>(element_in_brick(v))] = offset;
    return -std::int32_t{offset};
  });
  const auto like = DisplacementPlane::encode(box, values.back().u.data());
  planes.push_back(DisplacementPlane::adopt({0, -1, like->lowest(), like->highest(), like->moved()},
                                            std::move(offsets)));
  planes.back()->page_through(store);
  store->hold_budget();
  for (int n = 0; n < 3; ++n) {
    for (std::size_t i = 0; i < planes.size(); ++i) {
      ASSERT_NE(planes[i]->paged(), nullptr);
      EXPECT_FALSE(planes[i]->constant());
      expect_same(*planes[i], values[i]);
    }
  }
  EXPECT_GT(store->counters().planes_read, 0);
}

TEST(Lattice, BricksOfBoxesAndExtremesOfTheirPlanes) {
  const Size3 size{40, 33, 5};
  std::vector<glm::ivec3> u(static_cast<std::size_t>(voxel_count(size)), glm::ivec3(0));
  const auto at = [&](VoxelIndex v) -> glm::ivec3& {
    return u[static_cast<std::size_t>(linear_index(v, size))];
  };
  at({3, 4, 1}) = {5, 0, 0};
  at({10, 2, 4}) = {0, -7, 0};
  at({39, 32, 0}) = {0, 0, 600'000};
  const Lattice lattice = lattice_of(size, u);
  for_each_voxel(size, [&](VoxelIndex v) { ASSERT_EQ(lattice.u(v), at(v)); });
  EXPECT_EQ(lattice.brick_count(), 2);  // the other two rest
  const LatticeBrick& first = *lattice.brick(0);
  EXPECT_EQ(first.lowest(), glm::ivec3(0, -7, 0));
  EXPECT_EQ(first.highest(), glm::ivec3(5, 0, 0));
  EXPECT_EQ(first.moved(), (VoxelBox{{3, 2, 1}, {11, 5, 5}}));
  EXPECT_EQ(first.plane(2), nullptr);
  const LatticeBrick& last = *lattice.brick(3);
  EXPECT_EQ(last.moved(), (VoxelBox{{39, 32, 0}, {40, 33, 1}}));
  EXPECT_EQ(last.highest(), glm::ivec3(0, 0, 600'000));
  // Two planes of 2 bytes and one of 4 an element.
  EXPECT_GE(lattice.bytes(), 8 * kBrickVoxels);
  EXPECT_LT(lattice.bytes(), 8 * kBrickVoxels + 5 * kSmall_bytes);
}

}  // namespace
}  // namespace maille
