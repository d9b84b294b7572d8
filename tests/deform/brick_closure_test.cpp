// Every version of the brick's closure that this machine can run, against the plainest.
#include "deform/brick_closure.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "deform/cuts_edit.h"
#include "tests/deform/scenes.h"

namespace maille {
namespace {

using testing::constant_volume;
using testing::material;
using testing::random_volume;
using testing::table;

template <class L>
struct Closed {
  AlignedArray<L> labels = make_aligned_array<L>(kBrickVoxels);
  DirtyRows reached;
  MovedLabels<L> moved;
  std::array<std::uint32_t, kBrickEdge * kBrickEdge> moved_rows{};
};

// A volume of one brick, or of a part of one, whose links are all alike or of four materials; what
// is cut, how far it has moved before and which labels are raised is random.
template <class L>
class RandomBrick {
 public:
  explicit RandomBrick(unsigned seed)
      : random_(seed), size_(1 + below(32), 1 + below(32), 1 + below(32)), grid_(size_) {
    const bool alike = below(2) == 0;
    field_.emplace(alike ? constant_volume(size_) : random_volume(size_, 4, 1 + below(9), seed),
                   table({material(0, 1, 0.5, 1.5, 0.2), material(1, 2, 1, 1, 0),
                          material(2, 3, 0.99, 1.01, 0.01), material(3, 4, 0, 100, 90)}));
    cuts_ = Cuts(size_);
    start_ = Lattice(size_);
    if (below(2)) remove_links();
    if (below(2)) move_elements();
    bricks_.emplace(*field_, cuts_, none_, AnchorRules{});
    for (int n = 1 + below(4); n > 0; --n) {
      seeds_.emplace_back(VoxelIndex(below(size_.x), below(size_.y), below(size_.z)),
                          static_cast<L>(1 + below(sizeof(L) == 2 ? 65535 : 2000000)));
    }
    overshoot_ = static_cast<L>(below(3) == 0 ? below(5000) : 0);
  }

  Closed<L> closed_by(int version) {
    Closed<L> closed;
    std::fill_n(closed.labels.get(), kBrickVoxels, L{0});
    DirtyRows dirty;
    for (const auto& [voxel, label] : seeds_) {
      L& at = closed.labels[static_cast<std::size_t>(element_in_brick(voxel))];
      at = std::max(at, label);
      dirty.mark(voxel.y, voxel.z);
    }
    const DirectedLimits<L> limits(bricks_->table(), 1, false);
    BrickSlack<L> slack;
    slack.begin(*bricks_, bricks_->of(0), start_, limits);
    close_brick(closed.labels.get(), size_, slack, dirty, closed.reached, version);
    EXPECT_FALSE(dirty.any());
    closed.moved = lower_labels(closed.labels.get(), size_, closed.reached, overshoot_,
                                closed.moved_rows.data(), version);
    return closed;
  }

 private:
  int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }

  void remove_links() {
    CutsEdit edit(cuts_);
    for (int n = 0; n < 2000; ++n) {
      const VoxelIndex v{below(size_.x), below(size_.y), below(size_.z)};
      const int axis = below(3);
      if (v[axis] + 1 < size_[axis]) edit.set_removed(v, axis, true);
    }
    cuts_ = edit.finish();
  }
  void move_elements() {
    auto u = std::make_unique<BrickDisplacements>();
    for (auto& component : u->u) {
      for (std::int32_t& value : component) value = below(300);
    }
    start_.set(0, LatticeBrick::create(grid_.box(BrickIndex(0)), *u));
  }

  std::mt19937 random_;
  Size3 size_;
  BrickGrid grid_;
  std::optional<MaterialField> field_;
  Cuts cuts_;
  Lattice start_;
  ElementSet none_;
  std::optional<StrokeBricks> bricks_;
  std::vector<std::pair<VoxelIndex, L>> seeds_;
  L overshoot_ = 0;
};

template <class L>
void expect_versions_equal(unsigned seed) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  RandomBrick<L> brick(seed);
  const Closed<L> plain = brick.closed_by(0);
  for (int version = 1; version < closure_versions(); ++version) {
    SCOPED_TRACE("version " + std::to_string(version));
    const Closed<L> other = brick.closed_by(version);
    ASSERT_TRUE(
        std::equal(plain.labels.get(), plain.labels.get() + kBrickVoxels, other.labels.get()));
    EXPECT_EQ(plain.reached.rows, other.reached.rows);
    EXPECT_EQ(plain.moved_rows, other.moved_rows);
    EXPECT_EQ(plain.moved.any, other.moved.any);
    EXPECT_EQ(plain.moved.lowest, other.moved.lowest);
    EXPECT_EQ(plain.moved.highest, other.moved.highest);
    EXPECT_EQ(plain.moved.newly_moved, other.moved.newly_moved);
    EXPECT_EQ(plain.moved.box, other.moved.box);
  }
}

class BrickClosure : public ::testing::TestWithParam<int> {};

TEST_P(BrickClosure, IsTheSameInEveryWidth) {
  if (closure_versions() == 1) GTEST_SKIP() << "this machine has one version";
  expect_versions_equal<std::uint16_t>(static_cast<unsigned>(GetParam()));
  expect_versions_equal<std::uint32_t>(static_cast<unsigned>(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(Seeds, BrickClosure, ::testing::Range(1, 81));

}  // namespace
}  // namespace maille
