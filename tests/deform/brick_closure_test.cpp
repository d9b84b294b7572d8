// Every version of the closure of one brick against a plain fixed-point iteration over its links,
// whose slack is told here from the materials and displacements alone.
#include "deform/brick_closure.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "deform/cuts_edit.h"
#include "tests/deform/lattices.h"
#include "tests/deform/scenes.h"

namespace maille {
namespace {

using testing::constant_volume;
using testing::for_each_link_of;
using testing::for_each_voxel;
using testing::lattice_of;
using testing::material;
using testing::random_lattice;
using testing::random_volume;
using testing::table;

struct Scene {
  MaterialField field;
  Lattice start;
  Cuts cuts;
  int component = 0;
  bool downwards = false;
};

// Tables whose widest limits are as wide as 16 bits allow.
MaterialTable wide_table() {
  constexpr double kMost = 65535.0 / kUnitsPerVoxel;
  return table({material(0, 1, 1, 1, 0), material(1, 2, 0.9, 1.1, 0.05),
                material(2, 3, 0, 1 + kMost, kMost), material(3, 4, 0.5, 1.5, 0.25)});
}

// The links of one brick, and the fixed point over them: one by one until nothing rises.
class PlainBrick {
 public:
  PlainBrick(const Scene& scene, const VoxelBox& box) {
    const int c = scene.component;
    std::vector<MaterialId> ids(kBrickVoxels);
    for_each_voxel(box.size(), [&](VoxelIndex v) {
      ids[static_cast<std::size_t>(element_in_brick(v))] = scene.field.at(box.lo + v);
    });
    for_each_link_of(box.size(), [&](VoxelIndex i, int axis, VoxelIndex j) {
      if (scene.cuts.removed(box.lo + i, axis)) return;
      const auto lower = static_cast<std::size_t>(element_in_brick(i));
      const auto upper = static_cast<std::size_t>(element_in_brick(j));
      const LinkLimits limits = scene.field.table().link(ids[lower], ids[upper]);
      const auto a = static_cast<std::size_t>(axis);
      const std::int64_t stretch =
          std::int64_t{scene.start.u(box.lo + j)[c]} - scene.start.u(box.lo + i)[c];
      // Upwards, the lower element pushes the upper one once the link is as short as it gets.
      const std::int64_t shortest = std::max<std::int64_t>(0, stretch - limits.lower[a][c]);
      const std::int64_t longest = std::max<std::int64_t>(0, limits.upper[a][c] - stretch);
      links_.push_back({lower, upper, scene.downwards ? longest : shortest,
                        scene.downwards ? shortest : longest});
    });
  }

  void close(std::vector<std::int64_t>& labels) const {
    for (bool rises = true; rises;) {
      rises = false;
      const auto raise = [&](std::int64_t& label, std::int64_t to) {
        if (to <= label) return;
        label = to;
        rises = true;
      };
      for (const Link& l : links_) raise(labels[l.upper], labels[l.lower] - l.up);
      for (auto l = links_.rbegin(); l != links_.rend(); ++l) {
        raise(labels[l->lower], labels[l->upper] - l->down);
      }
    }
  }

 private:
  struct Link {
    std::size_t lower, upper;
    std::int64_t up, down;
  };
  std::vector<Link> links_;
};

template <class L>
struct Closed {
  AlignedArray<L> labels = make_aligned_array<L>(kBrickVoxels);
  DirtyRows reached;

  Closed() { std::fill_n(labels.get(), kBrickVoxels, L{0}); }
};

void mark_row_of(std::size_t element, DirtyRows& rows) {
  rows.mark(static_cast<int>(element / 32 % 32), static_cast<int>(element / 1024));
}

// Seeds labels of at most `highest` at random elements, closes, and seeds again: what arrives from
// other bricks comes in several goes.
template <class L>
void check(const Scene& scene, BrickIndex index, L highest, unsigned seed) {
  SCOPED_TRACE(::testing::Message() << "seed " << seed << ", component " << scene.component
                                    << (scene.downwards ? " down" : " up"));
  std::mt19937 random(seed);
  const ElementSet nothing;
  StrokeBricks bricks(scene.field, scene.cuts, nothing, {});
  const StrokeBrick& brick = bricks.of(bricks.grid().linear(index));
  const DirectedLimits<L> limits(scene.field.table(), scene.component, scene.downwards);
  const Size3 extent = brick.box.size();
  const PlainBrick plain(scene, brick.box);
  const int versions = closure_versions();
  std::vector<Closed<L>> of(static_cast<std::size_t>(versions));
  std::vector<std::int64_t> expected(kBrickVoxels, 0);
  for (int go = 0; go < 3; ++go) {
    std::vector<std::pair<std::size_t, L>> seeds;
    for (unsigned n = go == 0 ? 1 : 1 + random() % 40; n > 0; --n) {
      const VoxelIndex v(random() % static_cast<unsigned>(extent.x),
                         random() % static_cast<unsigned>(extent.y),
                         random() % static_cast<unsigned>(extent.z));
      const auto label = static_cast<L>(n % 3 == 1 ? highest : random() % (highest + L{1}));
      seeds.emplace_back(element_in_brick(v), std::max(label, L{1}));
    }
    for (const auto& [e, label] : seeds) expected[e] = std::max<std::int64_t>(expected[e], label);
    plain.close(expected);
    DirtyRows risen;
    for (std::size_t e = 0; e < expected.size(); ++e) {
      if (expected[e] > 0) mark_row_of(e, risen);
    }
    for (int v = 0; v < versions; ++v) {
      Closed<L>& mine = of[static_cast<std::size_t>(v)];
      DirtyRows dirty;
      for (const auto& [e, label] : seeds) {
        if (label <= mine.labels[e]) continue;
        mine.labels[e] = label;
        mark_row_of(e, dirty);
      }
      BrickSlack<L> slack;
      slack.begin(bricks, brick, scene.start, limits);
      close_brick(mine.labels.get(), extent, slack, dirty, mine.reached, v);
      EXPECT_FALSE(dirty.any());
      EXPECT_EQ(mine.reached.rows, risen.rows) << "version " << v << ", go " << go;
      std::int64_t differences = 0;
      for (std::size_t e = 0; e < kBrickVoxels; ++e) differences += mine.labels[e] != expected[e];
      ASSERT_EQ(differences, 0) << "version " << v << ", go " << go;
    }
  }
}

void check_both_widths(Scene scene, BrickIndex index, unsigned seed) {
  for (int c = 0; c < 3; ++c) {
    scene.component = c;
    scene.downwards = (static_cast<unsigned>(c) + seed) % 2 != 0;
    check<std::uint16_t>(scene, index, 6000, seed);
    check<std::uint16_t>(scene, index, 65535, seed + 1);
    check<std::uint32_t>(scene, index, 6000, seed);
    check<std::uint32_t>(scene, index, 512'000'000, seed + 1);
  }
}

constexpr Size3 kSizes[] = {{32, 32, 32}, {1, 1, 1},   {1, 32, 9}, {32, 1, 7},
                            {31, 5, 1},   {17, 32, 3}, {2, 3, 32}, {33, 40, 34}};

TEST(BrickClosure, InOneMaterial) {
  unsigned seed = 1;
  for (const Size3 size : kSizes) {
    SCOPED_TRACE(::testing::Message() << size.x << 'x' << size.y << 'x' << size.z);
    const MaterialField field(constant_volume(size), table({material(0, 1, 0.4, 1.7, 0.21)}));
    check_both_widths({field, Lattice(size), Cuts(size)}, {0, 0, 0}, seed += 10);
  }
  // Zero slack, and one whose doubled sums pass 65535.
  const Size3 size{32, 20, 32};
  for (const int value : {0, 2}) {
    const MaterialField field(constant_volume(size, static_cast<std::uint8_t>(value)),
                              wide_table());
    check_both_widths({field, Lattice(size), Cuts(size)}, {0, 0, 0}, seed += 10);
  }
}

TEST(BrickClosure, WithASlackOfItsOwnForEveryLink) {
  unsigned seed = 1000;
  for (const Size3 size : kSizes) {
    SCOPED_TRACE(::testing::Message() << size.x << 'x' << size.y << 'x' << size.z);
    const MaterialField field(random_volume(size, 4, 1, seed), wide_table());
    check_both_widths({field, Lattice(size), Cuts(size)}, {0, 0, 0}, seed += 10);
  }
  const Size3 size{65, 70, 40};
  const MaterialField field(random_volume(size, 4, 2, seed), wide_table());
  for (const BrickIndex index : {BrickIndex(1, 1, 0), BrickIndex(2, 2, 1)}) {
    check_both_widths({field, Lattice(size), Cuts(size)}, index, seed += 10);
  }
}

// Displaced links: slack beyond 16 bits counts as the most, below 0 as none.
TEST(BrickClosure, FromALatticeThatHasMoved) {
  unsigned seed = 2000;
  std::mt19937 random(3);
  for (const int most : {300, 40'000, 400'000'000}) {
    const Size3 size{40, 33, 20};
    const MaterialField one(constant_volume(size), table({material(0, 1, 0.4, 1.7, 0.21)}));
    const MaterialField many(random_volume(size, 4, 1, seed), wide_table());
    const Lattice start = random_lattice(size, most, 0.0, random);
    for (const MaterialField* field : {&one, &many}) {
      check_both_widths({*field, start, Cuts(size)}, {0, 0, 0}, seed += 10);
      check_both_widths({*field, start, Cuts(size)}, {1, 1, 0}, seed += 10);
    }
  }
}

// A brick that moved as a whole has no slack of its own for each link.
TEST(BrickClosure, FromABrickThatHasMovedAsOne) {
  const Size3 size{32, 32, 10};
  const MaterialField field(constant_volume(size), table({material(0, 1, 0.4, 1.7, 0.21)}));
  const std::vector<glm::ivec3> moved(static_cast<std::size_t>(voxel_count(size)),
                                      glm::ivec3(-7000, 99'999'999, 3));
  check_both_widths({field, lattice_of(size, moved), Cuts(size)}, {0, 0, 0}, 3000);
}

// The highest label there is stops at a removed link all the same.
TEST(BrickClosure, WithLinksRemoved) {
  unsigned seed = 4000;
  for (const Size3 size : {Size3{32, 32, 12}, {20, 32, 5}, {40, 8, 33}}) {
    std::mt19937 random(seed);
    CutsEdit edit{Cuts(size)};
    for_each_link_of(size, [&](VoxelIndex lower, int axis, VoxelIndex) {
      if (random() % 3 == 0 || (axis == 0 && lower.x == 15)) edit.set_removed(lower, axis, true);
    });
    const Cuts cuts = edit.finish();
    const MaterialField rigid(constant_volume(size), wide_table());
    const MaterialField many(random_volume(size, 4, 1, seed), wide_table());
    for (const MaterialField* field : {&rigid, &many}) {
      check_both_widths({*field, Lattice(size), cuts}, {0, 0, 0}, seed += 10);
    }
  }
}

template <class L>
void check_lowering(Size3 extent, L highest, L overshoot, bool several, unsigned seed) {
  SCOPED_TRACE(::testing::Message() << extent.x << 'x' << extent.y << 'x' << extent.z
                                    << ", overshoot " << overshoot << ", seed " << seed);
  std::mt19937 random(seed);
  std::vector<L> labels(kBrickVoxels, L{0});
  std::vector<std::uint32_t> moved_before(kBrickEdge * kBrickEdge, 0);
  DirtyRows reached;
  const unsigned share = 1 + seed % 7;  // of the rows: all, or one in so many
  for_each_voxel(extent, [&](VoxelIndex v) {
    if (v.x == 0 && random() % share == 0) reached.mark(v.y, v.z);
    if (!((reached.rows[static_cast<std::size_t>(v.z)] >> v.y) & 1)) return;
    const auto e = static_cast<std::size_t>(element_in_brick(v));
    labels[e] = static_cast<L>(random() % (highest + L{1}));
    if (random() % 4 == 0) moved_before[e / 32] |= 1u << (e % 32);
  });
  MovedLabels<L> expected;
  std::vector<L> lowered(labels);
  auto moved_after = moved_before;
  expected.lowest = static_cast<L>(~L{0});
  for_each_voxel(extent, [&](VoxelIndex v) {
    const auto e = static_cast<std::size_t>(element_in_brick(v));
    lowered[e] = labels[e] > overshoot ? static_cast<L>(labels[e] - overshoot) : L{0};
    expected.lowest = std::min(expected.lowest, lowered[e]);
    expected.highest = std::max(expected.highest, lowered[e]);
    if (lowered[e] == 0) return;
    expected.any = true;
    expected.box = {glm::min(expected.box.lo, v), glm::max(expected.box.hi, v + 1)};
    const std::uint32_t bit = 1u << (e % 32);
    expected.newly_moved += !several || !(moved_before[e / 32] & bit);
    moved_after[e / 32] |= bit;
  });
  for (int version = 0; version < closure_versions(); ++version) {
    SCOPED_TRACE(version);
    const auto mine = make_aligned_array<L>(kBrickVoxels);
    std::copy(labels.begin(), labels.end(), mine.get());
    auto moved_rows = moved_before;
    const MovedLabels<L> found = lower_labels(mine.get(), extent, reached, overshoot,
                                              several ? moved_rows.data() : nullptr, version);
    ASSERT_TRUE(std::equal(lowered.begin(), lowered.end(), mine.get()));
    ASSERT_EQ(found.any, expected.any);
    EXPECT_EQ(found.newly_moved, expected.newly_moved);
    EXPECT_EQ(moved_rows, several ? moved_after : moved_before);
    if (!expected.any) continue;
    EXPECT_EQ(found.lowest, expected.lowest);
    EXPECT_EQ(found.highest, expected.highest);
    EXPECT_EQ(found.box, expected.box);
  }
}

TEST(BrickClosure, LowersLabelsAndSaysWhatIsLeft) {
  unsigned seed = 5000;
  for (const Size3 size : kSizes) {
    const Size3 extent = glm::min(size, Size3(kBrickEdge));
    for (const unsigned overshoot : {0u, 1u, 2990u, 3000u, 65535u}) {
      for (const bool several : {false, true}) {
        for (const unsigned highest : {3000u, 65535u}) {
          check_lowering(extent, static_cast<std::uint16_t>(highest),
                         static_cast<std::uint16_t>(overshoot), several, ++seed);
          check_lowering(extent, std::uint32_t{highest}, std::uint32_t{overshoot}, several, ++seed);
        }
        check_lowering(extent, std::uint32_t{512'000'000}, std::uint32_t{511'999'000}, several,
                       ++seed);
      }
    }
  }
}

}  // namespace
}  // namespace maille
