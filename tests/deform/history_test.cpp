#include "deform/history.h"

#include <random>

#include <gtest/gtest.h>

#include "deform/deformer.h"
#include "tests/deform/scenes.h"

namespace maille {
namespace {

using testing::constant_volume;
using testing::equal;
using testing::material;
using testing::random_volume;
using testing::table;
using testing::workers;

constexpr std::int64_t kPlaneBytes = kBrickVoxels * 2;

MaterialTable soft(double shear = 0.2) { return table({material(0, 1, 0.5, 1.5, shear)}); }

// All that undo has to bring back, in one number.
std::uint64_t hash_of(const Deformer& deformer) {
  std::uint64_t hash = 14695981039346656037u;
  const auto mix = [&](std::uint64_t value) { hash = (hash ^ value) * 1099511628211u; };
  const Size3 size = deformer.lattice().grid().volume_size();
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) {
        const glm::ivec3 u = deformer.lattice().u({x, y, z});
        for (int c = 0; c < 3; ++c) mix(static_cast<std::uint32_t>(u[c]));
      }
    }
  }
  for (const std::string& name : deformer.handle_names()) mix(std::hash<std::string>()(name));
  mix(static_cast<std::uint64_t>(deformer.materials().table().materials()[0].shear.x * 1e6));
  return hash;
}

void drag(Deformer& deformer, VoxelIndex from, glm::dvec3 by) {
  ASSERT_TRUE(deformer.begin_stroke(from, 1).ok());
  ASSERT_TRUE(deformer.drag_to(by, workers()).ok());
  deformer.end_stroke();
}

TEST(History, TenThousandRandomStrokesAndBackToTheFirstBit) {
  const unsigned seed = 20260512;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  const Size3 size{7, 5, 4};
  const auto tables = [](double shear) {
    return table({material(0, 1, 0.5, 1.5, shear), material(1, 2, 0.9, 1.1, 0.05)});
  };
  Deformer deformer(
      random_volume(size, 2, 2, seed), tables(0.2), {},
      {.undo_memory_bytes = std::int64_t{1} << 40, .lattice_memory_bytes = std::int64_t{64} << 20});
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  std::vector<std::uint64_t> states{hash_of(deformer)};
  for (int strokes = 0; strokes < 10000;) {
    if (below(10) == 0) {
      ASSERT_TRUE(deformer.set_materials(tables(0.1 + 0.01 * below(20))).ok());
    } else if (below(10) == 0 && !deformer.handle_names().empty()) {
      deformer.release_all();
    } else {
      const VoxelIndex from{below(size.x), below(size.y), below(size.z)};
      ASSERT_TRUE(deformer.begin_stroke(from, below(2)).ok());
      const auto far = [&] { return 0.01 * (below(600) - 300); };
      const glm::dvec3 by(far(), far(), far());
      ASSERT_TRUE(deformer.drag_to(by, workers()).ok());
      deformer.end_stroke();
      ++strokes;
    }
    states.push_back(hash_of(deformer));
  }
  const std::size_t steps = states.size() - 1;
  EXPECT_EQ(deformer.history()->undo_steps(), static_cast<std::int64_t>(steps));
  EXPECT_EQ(deformer.history()->dropped_steps(), 0);
  for (std::size_t n = steps; n-- > 0;) {
    ASSERT_TRUE(deformer.undo());
    ASSERT_EQ(hash_of(deformer), states[n]) << n;
  }
  EXPECT_TRUE(deformer.lattice().at_rest());
  EXPECT_FALSE(deformer.undo());
  for (std::size_t n = 1; n <= steps; ++n) {
    ASSERT_TRUE(deformer.redo());
    ASSERT_EQ(hash_of(deformer), states[n]) << n;
  }
  EXPECT_FALSE(deformer.redo());
}

TEST(History, TheOldestStepsAreDroppedForTheBudgetAndCounted) {
  Deformer deformer(constant_volume({12, 12, 12}), soft(), {},
                    {.undo_memory_bytes = 3 * kPlaneBytes});
  std::vector<std::uint64_t> states{hash_of(deformer)};
  for (int n = 1; n <= 8; ++n) {
    drag(deformer, {6, 6, 6}, {0.5, 0, 0});
    states.push_back(hash_of(deformer));
    EXPECT_LE(deformer.history()->bytes(), deformer.history()->budget_bytes());
  }
  EXPECT_GT(deformer.history()->dropped_steps(), 0);
  EXPECT_EQ(deformer.history()->undo_steps() + deformer.history()->dropped_steps(), 8);
  const auto left = static_cast<std::size_t>(deformer.history()->undo_steps());
  EXPECT_GE(left, 2u);
  for (std::size_t n = 0; n < left; ++n) {
    ASSERT_TRUE(deformer.undo());
    EXPECT_EQ(hash_of(deformer), states[7 - n]);
  }
  EXPECT_FALSE(deformer.undo());
}

TEST(History, KeepsOnlyWhatAStepChanged) {
  // Two bricks, each stroke within its own.
  Deformer deformer(constant_volume({64, 10, 10}), soft(), {});
  drag(deformer, {4, 5, 5}, {0, 0.5, 0});
  // What was there before was nothing.
  const std::int64_t first = deformer.history()->bytes();
  EXPECT_LT(first, 10000);
  drag(deformer, {60, 5, 5}, {0, 0.5, 0});
  const std::int64_t second = deformer.history()->bytes();
  EXPECT_LT(second - first, 10000);
  // Now the plane of one component of one brick goes out of the present.
  deformer.release_all();
  const std::int64_t third = deformer.history()->bytes();
  drag(deformer, {60, 5, 5}, {0, 0.75, 0});
  EXPECT_GE(deformer.history()->bytes() - third, kPlaneBytes);
  EXPECT_LT(deformer.history()->bytes() - third, kPlaneBytes + 10000);
}

TEST(History, ANewStepForgetsWhatWasUndone) {
  Deformer deformer(constant_volume({12, 12, 12}), soft(), {});
  drag(deformer, {3, 3, 3}, {0.5, 0, 0});
  drag(deformer, {8, 8, 8}, {0.5, 0, 0});
  ASSERT_TRUE(deformer.undo());
  ASSERT_TRUE(deformer.undo());
  EXPECT_EQ(deformer.history()->redo_steps(), 2);
  const std::int64_t undone = deformer.history()->bytes();
  EXPECT_GT(undone, kPlaneBytes);
  drag(deformer, {5, 5, 5}, {0, 0.5, 0});
  EXPECT_FALSE(deformer.redo());
  EXPECT_LT(deformer.history()->bytes(), kPlaneBytes);
}

TEST(History, MaterialEditsAreStepsAndActAtOnce) {
  Deformer deformer(constant_volume({12, 12, 12}), soft(), {});
  ASSERT_TRUE(deformer.set_materials(table({material(0, 1, 1, 1, 0)})).ok());
  drag(deformer, {3, 3, 3}, {0.5, 0, 0});
  // Rigid: everything has gone along.
  EXPECT_EQ(deformer.lattice().u({11, 11, 11}), glm::ivec3(256, 0, 0));
  ASSERT_TRUE(deformer.undo());
  ASSERT_TRUE(deformer.undo());
  EXPECT_EQ(deformer.materials().table().materials()[0].compress.x, 0.5);
  drag(deformer, {3, 3, 3}, {0.5, 0, 0});
  EXPECT_EQ(deformer.lattice().u({11, 11, 11}), glm::ivec3(0));
}

TEST(History, MaterialsDoNotChangeDuringAStroke) {
  Deformer deformer(constant_volume({12, 12, 12}), soft(), {});
  ASSERT_TRUE(deformer.begin_stroke({3, 3, 3}, 1).ok());
  const auto set = deformer.set_materials(soft(0.1));
  ASSERT_FALSE(set.ok());
  EXPECT_EQ(set.error().kind, ErrorKind::usage);
  EXPECT_EQ(deformer.history()->undo_steps(), 0);
}

// What relaxation did after a step goes back with it; after an undo it is forgotten by redo.
TEST(History, RelaxationBelongsToTheStepBefore) {
  Deformer deformer(constant_volume({40, 12, 12}), soft(), {});
  drag(deformer, {3, 3, 3}, {1, 0, 0});
  const std::uint64_t dragged = hash_of(deformer);
  drag(deformer, {8, 8, 8}, {0, 1, 0});
  const Lattice second = deformer.lattice();
  const auto relax = [&] {
    Relaxation relaxation = deformer.relax(workers(), {});
    for (int n = 0; n < 20; ++n) {
      relaxation.iterate();
      deformer.adopt(relaxation.lattice());
    }
  };
  relax();
  const std::uint64_t relaxed = hash_of(deformer);
  EXPECT_FALSE(equal(deformer.lattice(), second));
  ASSERT_TRUE(deformer.undo());
  EXPECT_EQ(hash_of(deformer), dragged);
  relax();
  EXPECT_NE(hash_of(deformer), dragged);
  ASSERT_TRUE(deformer.redo());
  EXPECT_EQ(hash_of(deformer), relaxed);
  ASSERT_TRUE(deformer.undo());
  ASSERT_TRUE(deformer.undo());
  EXPECT_TRUE(deformer.lattice().at_rest());
}

TEST(History, WithoutABudgetNoStepIsKept) {
  Deformer deformer(constant_volume({12, 12, 12}), soft(), {}, {.undo_memory_bytes = std::nullopt});
  drag(deformer, {3, 3, 3}, {1, 0, 0});
  EXPECT_EQ(deformer.history(), nullptr);
  EXPECT_FALSE(deformer.undo());
  EXPECT_FALSE(deformer.lattice().at_rest());
}

}  // namespace
}  // namespace maille
