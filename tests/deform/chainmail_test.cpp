#include "deform/chainmail.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "deform/violations.h"
#include "tests/deform/scenes.h"

namespace maille {
namespace {

using testing::constant_volume;
using testing::Drag;
using testing::equal;
using testing::material;
using testing::random_volume;
using testing::table;
using testing::workers;

// A row pulled at one end: each link takes what it may and hands on the rest.
TEST(ChainMail, OneRow) {
  const Size3 size{70, 1, 1};
  const MaterialField field(constant_volume(size), table({material(0, 1, 0.5, 1.25, 0.1)}));
  const Lattice rest(size);
  const Drag handle{field, rest, {{0, 0, 0}}};
  const int drag = 10 * kUnitsPerVoxel;
  const ChainMailAnswer pulled = handle.by({-drag, 0, 0});
  const ChainMailAnswer pushed = handle.by({drag, 0, 0});
  const ChainMailAnswer sheared = handle.by({0, drag, 0});
  for (int x = 0; x < size.x; ++x) {
    EXPECT_EQ(pulled.lattice.u({x, 0, 0}), glm::ivec3(-std::max(0, drag - 128 * x), 0, 0)) << x;
    EXPECT_EQ(pushed.lattice.u({x, 0, 0}), glm::ivec3(std::max(0, drag - 256 * x), 0, 0)) << x;
    EXPECT_EQ(sheared.lattice.u({x, 0, 0}), glm::ivec3(0, std::max(0, drag - 51 * x), 0)) << x;
  }
  EXPECT_EQ(pulled.elements_moved, 40);
  EXPECT_EQ(pushed.elements_moved, 20);
  EXPECT_FALSE(pulled.clamped);
}

// One material answers with an octahedron of known half axes.
TEST(ChainMail, OctahedronInOneMaterial) {
  const Size3 size{80, 70, 75};
  const MaterialField field(constant_volume(size), table({material(0, 1, 0.5, 1.75, 0.25)}));
  const Lattice rest(size);
  const VoxelIndex center{41, 33, 36};
  const Drag handle{field, rest, {center}};
  const glm::ivec3 by{9 * kUnitsPerVoxel, -4 * kUnitsPerVoxel, 700};
  const ChainMailAnswer answer = handle.by(by);
  std::int64_t moved = 0;
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) {
        const glm::ivec3 away = VoxelIndex(x, y, z) - center;
        glm::ivec3 expected;
        for (int c = 0; c < 3; ++c) {
          int used = 0;
          for (int axis = 0; axis < 3; ++axis) {
            const bool ahead = (away[axis] > 0) == (by[c] > 0);
            used += std::abs(away[axis]) * (axis != c ? 128 : ahead ? 256 : 384);
          }
          expected[c] = std::max(0, std::abs(by[c]) - used) * (by[c] > 0 ? 1 : -1);
        }
        moved += expected != glm::ivec3(0);
        ASSERT_EQ(answer.lattice.u({x, y, z}), expected) << x << ' ' << y << ' ' << z;
      }
    }
  }
  EXPECT_EQ(answer.elements_moved, moved);
  EXPECT_EQ(violations_of(answer.lattice, field, Cuts(field.size())).links, 0);
}

TEST(ChainMail, RigidBlockMovesWhole) {
  const Size3 size{64, 40, 40};
  std::vector<std::uint8_t> samples(static_cast<std::size_t>(voxel_count(size)), 0);
  const VoxelBox block{{20, 10, 12}, {45, 30, 33}};
  for (int z = block.lo.z; z < block.hi.z; ++z) {
    for (int y = block.lo.y; y < block.hi.y; ++y) {
      for (int x = block.lo.x; x < block.hi.x; ++x) {
        samples[static_cast<std::size_t>(linear_index({x, y, z}, size))] = 1;
      }
    }
  }
  const MaterialField field(
      Volume::of(size, VoxelType::uint8, axis_aligned(glm::dvec3(1)), std::move(samples)),
      table({material(0, 1, 0.5, 1.5, 0.2), material(1, 2, 1, 1, 0)}));
  const Lattice rest(size);
  const glm::ivec3 by{1234, -777, 42};
  const ChainMailAnswer answer = Drag{field, rest, {{30, 20, 20}}}.by(by);
  for (int z = block.lo.z; z < block.hi.z; ++z) {
    for (int y = block.lo.y; y < block.hi.y; ++y) {
      for (int x = block.lo.x; x < block.hi.x; ++x) {
        ASSERT_EQ(answer.lattice.u({x, y, z}), by);
      }
    }
  }
  EXPECT_EQ(violations_of(answer.lattice, field, Cuts(field.size())).links, 0);
}

TEST(ChainMail, StopsExactlyAtAnAnchor) {
  const Size3 size{50, 3, 3};
  Deformer deformer(constant_volume(size), table({material(0, 1, 0.5, 1.5, 0.25)}),
                    {face_low_x, false});
  ASSERT_TRUE(deformer.begin_stroke({20, 1, 1}, 0).ok());
  const auto report = deformer.drag_to({30, 0, 0}, workers());
  ASSERT_TRUE(report.ok());
  // 20 links stretched by half a voxel each, and not a unit more.
  EXPECT_TRUE(report->clamped);
  EXPECT_EQ(report->moved_by_voxels, glm::dvec3(10, 0, 0));
  EXPECT_EQ(deformer.lattice().u({0, 1, 1}), glm::ivec3(0));
  EXPECT_EQ(violations_of(deformer.lattice(), deformer.materials(), deformer.cuts()).links, 0);
  const auto within = deformer.drag_to({10, 0, 0}, workers());
  ASSERT_TRUE(within.ok());
  EXPECT_FALSE(within->clamped);
}

TEST(ChainMail, AViolatedStartGetsNoWorse) {
  const Size3 size{40, 1, 1};
  const MaterialField field(constant_volume(size), table({material(0, 1, 0.9, 1.1, 0.1)}));
  // A jump of two voxels where a tenth is allowed, as no drag but only relaxation could leave it.
  auto brick = std::make_unique<BrickDisplacements>();
  for (int x = 10; x < 32; ++x) brick->u[0][x] = 1024;
  Lattice start(size);
  start.set(0, LatticeBrick::create({{0, 0, 0}, {32, 1, 1}}, *brick));
  const Violations before = violations_of(start, field, Cuts(field.size()));
  EXPECT_GT(before.links, 0);
  const ChainMailAnswer answer = Drag{field, start, {{20, 0, 0}}}.by({3000, 0, 0});
  const Violations after = violations_of(answer.lattice, field, Cuts(field.size()));
  EXPECT_LE(after.links, before.links);
  EXPECT_LE(after.worst_voxels, before.worst_voxels);
}

TEST(Deformer, AStrokeIsAFunctionOfItsTotalDrag) {
  const Size3 size{60, 60, 60};
  Deformer deformer(random_volume(size, 3, 4, 7),
                    table({material(0, 1, 0.5, 1.5, 0.2), material(1, 2, 0.9, 1.1, 0.05),
                           material(2, 3, 1, 1, 0)}),
                    {});
  ASSERT_TRUE(deformer.begin_stroke({30, 30, 30}, 3, "a").ok());
  ASSERT_TRUE(deformer.drag_to({8, -3, 2}, workers()).ok());
  const Lattice once = deformer.lattice();
  for (const double x : {2.0, 20.0, -4.0, 8.0})
    ASSERT_TRUE(deformer.drag_to({x, -3, 2}, workers()).ok());
  EXPECT_TRUE(equal(deformer.lattice(), once));
  ASSERT_TRUE(deformer.drag_to({0, 0, 0}, workers()).ok());
  EXPECT_TRUE(deformer.lattice().at_rest());
  ASSERT_TRUE(deformer.drag_to({5, 0, 0}, workers()).ok());
  deformer.cancel_stroke();
  EXPECT_TRUE(deformer.lattice().at_rest());
  EXPECT_TRUE(deformer.handle_names().empty());
}

TEST(Deformer, UndoAndRedoRestoreEveryBit) {
  const Size3 size{50, 50, 50};
  Deformer deformer(constant_volume(size), table({material(0, 1, 0.5, 1.5, 0.2)}), {});
  std::vector<Lattice> states{deformer.lattice()};
  for (int n = 0; n < 3; ++n) {
    ASSERT_TRUE(deformer.begin_stroke({10 + 12 * n, 25, 25}, 1).ok());
    ASSERT_TRUE(deformer.drag_to({0, 4.5 + n, 1}, workers()).ok());
    deformer.end_stroke();
    states.push_back(deformer.lattice());
  }
  EXPECT_EQ(deformer.handle_names().size(), 3u);
  for (std::size_t n = 3; n-- > 0;) {
    ASSERT_TRUE(deformer.undo());
    EXPECT_TRUE(equal(deformer.lattice(), states[n]));
  }
  EXPECT_FALSE(deformer.undo());
  for (std::size_t n = 1; n <= 3; ++n) {
    ASSERT_TRUE(deformer.redo());
    EXPECT_TRUE(equal(deformer.lattice(), states[n]));
  }
  EXPECT_FALSE(deformer.redo());
  EXPECT_EQ(deformer.handle_names().size(), 3u);
}

TEST(Deformer, RefusesWhatCannotBeDone) {
  Deformer deformer(constant_volume({10, 10, 10}), table({material(0, 1, 0.5, 1.5, 0.2)}), {});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(deformer.drag_to({1, 0, 0}, workers()).ok());
  EXPECT_FALSE(deformer.begin_stroke({10, 0, 0}, 1).ok());
  EXPECT_FALSE(deformer.begin_stroke({0, 0, 0}, -1).ok());
  EXPECT_FALSE(deformer.begin_stroke({0, 0, 0}, nan).ok());
  ASSERT_TRUE(deformer.begin_stroke({5, 5, 5}, 1).ok());
  EXPECT_FALSE(deformer.begin_stroke({5, 5, 5}, 1).ok());
  EXPECT_FALSE(deformer.drag_to({nan, 0, 0}, workers()).ok());
  EXPECT_FALSE(deformer.drag_to({0, 1.1e6, 0}, workers()).ok());
  EXPECT_TRUE(deformer.drag_to({0, 1e6, 0}, workers()).ok());
  EXPECT_TRUE(deformer.drag_to({0, 1e-6, 0}, workers()).ok());
  EXPECT_FALSE(deformer.release("nobody").ok());
}

TEST(Deformer, StrokesTogetherStayWithinReach) {
  Deformer deformer(constant_volume({10, 10, 10}), table({material(0, 1, 1, 1, 0)}), {});
  ASSERT_TRUE(deformer.begin_stroke({5, 5, 5}, 1).ok());
  ASSERT_TRUE(deformer.drag_to({9e5, 0, 0}, workers()).ok());
  deformer.end_stroke();
  ASSERT_TRUE(deformer.begin_stroke({5, 5, 5}, 1).ok());
  EXPECT_FALSE(deformer.drag_to({2e5, 0, 0}, workers()).ok());
  EXPECT_FALSE(deformer.drag_to({-2e5, 0, 0}, workers()).ok());
  ASSERT_TRUE(deformer.drag_to({1e5, 0, 0}, workers()).ok());
  EXPECT_EQ(deformer.lattice().u({0, 0, 0}), glm::ivec3(512'000'000, 0, 0));
}

TEST(Deformer, HandlesAnswerToTheirNames) {
  Deformer deformer(constant_volume({60, 20, 20}), table({material(0, 1, 0.2, 3, 0.5)}), {});
  const auto drag = [&](int x, const char* name) {
    if (!deformer.begin_stroke({x, 10, 10}, 2, name).ok()) return false;
    EXPECT_TRUE(deformer.drag_to({0, 0.5, 0}, workers()).ok());
    deformer.end_stroke();
    return true;
  };
  ASSERT_TRUE(drag(10, "a"));
  EXPECT_FALSE(drag(50, "a"));
  EXPECT_EQ(deformer.handle_names(), std::vector<std::string>{"a"});
  ASSERT_TRUE(drag(11, "b"));  // touches a: one handle with two names
  EXPECT_EQ(deformer.handle_names(), (std::vector<std::string>{"a", "b"}));
  EXPECT_TRUE(deformer.release("a").ok());
  EXPECT_TRUE(deformer.handle_names().empty());
}

TEST(Deformer, MaterialEditsActOnTheNextDrag) {
  const Size3 size{40, 1, 1};
  Deformer deformer(constant_volume(size), table({material(0, 1, 0.5, 1.5, 0.2)}), {});
  const auto reach = [&] {
    EXPECT_TRUE(deformer.begin_stroke({0, 0, 0}, 0).ok());
    const auto report = deformer.drag_to({-5, 0, 0}, workers());
    deformer.cancel_stroke();
    return report->elements_moved;
  };
  EXPECT_EQ(reach(), 10);
  ASSERT_TRUE(deformer.set_materials(table({material(0, 1, 0.5, 1.25, 0.2)})).ok());
  EXPECT_EQ(reach(), 20);
}

TEST(Deformer, GrabsWhatMayMoveAndTakesPinnedHandlesAlong) {
  const Size3 size{30, 30, 30};
  std::vector<std::uint8_t> samples(static_cast<std::size_t>(voxel_count(size)), 0);
  for (int z = 0; z < 15; ++z) {
    for (int i = 0; i < 900; ++i) samples[static_cast<std::size_t>(z * 900 + i)] = 1;
  }
  Deformer deformer(
      Volume::of(size, VoxelType::uint8, axis_aligned(glm::dvec3(1)), std::move(samples)),
      table({material(0, 1, 0.2, 3, 1), material(1, 2, 1, 1, 0, 1000, true)}), {});
  // The ball reaches into what is fixed; the skin over it still moves.
  ASSERT_TRUE(deformer.begin_stroke({15, 15, 17}, 4, "skin").ok());
  auto report = deformer.drag_to({0, 0, 0.5}, workers());
  ASSERT_TRUE(report.ok());
  EXPECT_FALSE(report->clamped);
  deformer.end_stroke();
  ASSERT_TRUE(deformer.begin_stroke({15, 15, 18}, 1).ok());
  report = deformer.drag_to({0, 0, 0.25}, workers());
  ASSERT_TRUE(report.ok());
  EXPECT_FALSE(report->clamped);
  deformer.end_stroke();
  EXPECT_EQ(deformer.handle_names(), std::vector<std::string>{"skin"});
  EXPECT_EQ(deformer.lattice().u({15, 15, 15}).z, 384);
  // A handle of fixed elements alone says that it is held.
  ASSERT_TRUE(deformer.begin_stroke({15, 15, 5}, 2).ok());
  report = deformer.drag_to({1, 0, 0}, workers());
  ASSERT_TRUE(report.ok());
  EXPECT_TRUE(report->clamped);
  EXPECT_EQ(report->moved_by_voxels, glm::dvec3(0));
}

}  // namespace
}  // namespace maille
