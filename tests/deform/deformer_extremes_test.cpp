// What a person can do to the deformer that nobody should, and what it says.
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "deform/deformer.h"
#include "tests/deform/dense_twin.h"

namespace maille {
namespace {

using testing::constant_volume;
using testing::Drag;
using testing::equal;
using testing::exactly;
using testing::expect_displacements;
using testing::material;
using testing::random_volume;
using testing::table;
using testing::workers;

constexpr int kVoxel = kUnitsPerVoxel;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// One material in a row: 0.5 to 1.25 of the spacing.
Deformer row_of(int length, AnchorRules anchors = {}) {
  return Deformer(constant_volume({length, 1, 1}), table({material(0, 1, 0.5, 1.25, 0.125)}),
                  anchors);
}

DragReport dragged(Deformer& deformer, glm::dvec3 by_voxels) {
  auto report = deformer.drag_to(by_voxels, workers());
  EXPECT_TRUE(report.ok()) << (report.ok() ? "" : report.error().message);
  return report.ok() ? *report : DragReport{};
}

// A whole stroke; the handle stays where it was left.
DragReport stroke(Deformer& deformer, VoxelIndex from, glm::dvec3 by_voxels, double radius = 0) {
  EXPECT_TRUE(deformer.begin_stroke(from, radius).ok());
  const DragReport report = dragged(deformer, by_voxels);
  deformer.end_stroke();
  return report;
}

std::int64_t violated(const Deformer& deformer) {
  return violations_of(deformer.lattice(), deformer.materials(), deformer.cuts()).links;
}

TEST(DeformerExtremes, DragsOfNoNumberAreRefusedAndNothingMoves) {
  Deformer deformer = row_of(40);
  ASSERT_TRUE(deformer.begin_stroke({20, 0, 0}, 1).ok());
  const DragReport before = dragged(deformer, {3, -2, 1});
  EXPECT_EQ(before.moved_by_voxels, glm::dvec3(3, -2, 1));
  const Lattice lattice = deformer.lattice();
  for (int c = 0; c < 3; ++c) {
    for (const double bad : {kNan, -kNan, kInfinity, -kInfinity, 1e6 + 1, -1e300}) {
      glm::dvec3 by(1);
      by[c] = bad;
      const auto refused = deformer.drag_to(by, workers());
      ASSERT_FALSE(refused.ok()) << bad;
      EXPECT_EQ(refused.error().kind, ErrorKind::usage);
      EXPECT_NE(refused.error().message.find("1000000 voxels"), std::string::npos)
          << refused.error().message;
      Lattice::for_each_difference(deformer.lattice(), lattice,
                                   [](std::int64_t b) { ADD_FAILURE() << b; });
    }
  }
  // The stroke goes on.
  EXPECT_TRUE(deformer.in_stroke());
  EXPECT_FALSE(dragged(deformer, {1, 0, 0}).clamped);
}

TEST(DeformerExtremes, GrabsOfNoBallAreRefused) {
  Deformer deformer = row_of(40);
  for (const double radius : {-1.0, -1e-300, kNan, kInfinity}) {
    const auto refused = deformer.begin_stroke({20, 0, 0}, radius);
    ASSERT_FALSE(refused.ok()) << radius;
    EXPECT_NE(refused.error().message.find("radius"), std::string::npos);
  }
  for (const VoxelIndex outside : {VoxelIndex(-1, 0, 0), VoxelIndex(40, 0, 0), VoxelIndex(0, 1, 0),
                                   VoxelIndex(0, 0, std::numeric_limits<int>::min()),
                                   VoxelIndex(std::numeric_limits<int>::max(), 0, 0)}) {
    const auto refused = deformer.begin_stroke(outside, 1);
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().message.find("outside the volume"), std::string::npos);
  }
  EXPECT_FALSE(deformer.in_stroke());
  EXPECT_FALSE(deformer.drag_to({1, 0, 0}, workers()).ok());
  // A ball larger than anything is the volume.
  ASSERT_TRUE(deformer.begin_stroke({20, 0, 0}, 1e9).ok());
  EXPECT_EQ(dragged(deformer, {2, 0, 0}).elements_moved, 40);
}

// 1e-6 voxel is less than half a unit; half a unit is one.
TEST(DeformerExtremes, DragsBelowTheUnit) {
  Deformer deformer = row_of(40);
  ASSERT_TRUE(deformer.begin_stroke({20, 0, 0}, 0).ok());
  for (const double small : {0.0, -0.0, 1e-6, -1e-6, 1e-308, 0.49 / kVoxel}) {
    const DragReport report = dragged(deformer, {small, -small, small});
    EXPECT_EQ(report.elements_moved, 0);
    EXPECT_EQ(report.moved_by_voxels, glm::dvec3(0));
    EXPECT_FALSE(report.clamped);
    EXPECT_TRUE(deformer.lattice().at_rest());
  }
  const DragReport report = dragged(deformer, {0.51 / kVoxel, 0, 0});
  EXPECT_EQ(report.elements_moved, 1);
  EXPECT_EQ(deformer.lattice().u({20, 0, 0}), glm::ivec3(1, 0, 0));
}

// Longer than the volume, and as long as a drag may be: every element is somewhere on the way.
TEST(DeformerExtremes, DragsLongerThanTheVolume) {
  const Size3 size{40, 3, 35};
  Deformer deformer(constant_volume(size), table({material(0, 1, 0.5, 1.25, 0.125)}), {});
  const VoxelIndex handle{0, 1, 33};
  ASSERT_TRUE(deformer.begin_stroke(handle, 0).ok());
  for (const double length : {100.0, 5000.0, 1e6}) {
    const DragReport report = dragged(deformer, {length, -length, length});
    EXPECT_EQ(report.elements_moved, voxel_count(size));
    EXPECT_EQ(report.moved_by_voxels, glm::dvec3(length, -length, length));
    const int drag = static_cast<int>(length) * kVoxel;
    expect_displacements(deformer.lattice(), [&](VoxelIndex v) {
      const glm::ivec3 away = v - handle;
      const glm::ivec3 steps = glm::abs(away);
      // Pushed ahead a link gives 256 units, pulled behind 128, across 64.
      const int x = drag - 256 * steps.x - 64 * (steps.y + steps.z);
      const int y = drag - (away.y < 0 ? 256 : 128) * steps.y - 64 * (steps.x + steps.z);
      const int z = drag - (away.z > 0 ? 256 : 128) * steps.z - 64 * (steps.x + steps.y);
      return glm::ivec3(x, -y, z);
    });
    EXPECT_EQ(violated(deformer), 0);
  }
  dragged(deformer, {0, 0, 0});
  EXPECT_TRUE(deformer.lattice().at_rest());
}

// The second handle gets as far as 40 links stretch or shorten, to the unit, and says so.
TEST(DeformerExtremes, TwoHandlesInARowPulledApartAndPushedTogether) {
  Deformer deformer = row_of(100);
  EXPECT_FALSE(stroke(deformer, {20, 0, 0}, {-5, 0, 0}).clamped);
  ASSERT_TRUE(deformer.begin_stroke({60, 0, 0}, 0).ok());
  const DragReport apart = dragged(deformer, {30, 0, 0});
  EXPECT_TRUE(apart.clamped);
  EXPECT_EQ(apart.moved_by_voxels, glm::dvec3(-5 + 40 * 0.25, 0, 0));
  EXPECT_EQ(deformer.lattice().u({20, 0, 0}), glm::ivec3(-5 * kVoxel, 0, 0));
  EXPECT_EQ(violated(deformer), 0);
  const DragReport together = dragged(deformer, {-100, 0, 0});
  EXPECT_TRUE(together.clamped);
  EXPECT_EQ(together.moved_by_voxels, glm::dvec3(-5 - 40 * 0.5, 0, 0));
  const DragReport across = dragged(deformer, {0, -7, 9e5});
  EXPECT_TRUE(across.clamped);
  EXPECT_EQ(across.moved_by_voxels, glm::dvec3(0, -5, 5));  // an eighth of a voxel a link
  // Exactly as far is not clamped, a unit further is.
  EXPECT_FALSE(dragged(deformer, {5, 0, 0}).clamped);
  EXPECT_TRUE(dragged(deformer, {5 + 1.0 / kVoxel, 0, 0}).clamped);
  EXPECT_EQ(violated(deformer), 0);
}

// Without being held, out and back in two strokes leaves what ChainMail leaves: no violation, and
// the handle at home.
TEST(DeformerExtremes, TwoOppositeStrokes) {
  const Size3 size{50, 33, 20};
  Deformer deformer(
      random_volume(size, 3, 2, 61),
      table({material(0, 1, 0.5, 1.5, 0.25), material(1, 2, 1, 1, 0), material(2, 3, 0, 101, 100)}),
      {});
  const VoxelIndex handle{31, 16, 10};
  const glm::dvec3 by(40, -200, 7.5);
  stroke(deformer, handle, by);
  deformer.release_all();
  const Lattice out = deformer.lattice();
  const DragReport back = stroke(deformer, handle, -by);
  EXPECT_EQ(back.moved_by_voxels, -by);
  EXPECT_EQ(deformer.lattice().u(handle), glm::ivec3(0));
  EXPECT_EQ(violated(deformer), 0);
  const Drag drag{deformer.materials(), out, {handle}};
  EXPECT_TRUE(equal(exactly(drag, glm::ivec3(-by * 512.0)).lattice, deformer.lattice()));
  // In one stroke, out and back is nothing.
  ASSERT_TRUE(deformer.undo());
  EXPECT_TRUE(equal(deformer.lattice(), out));
  ASSERT_TRUE(deformer.begin_stroke(handle, 2).ok());
  dragged(deformer, {-300, 20, 1});
  dragged(deformer, {0, 0, 0});
  EXPECT_TRUE(same_displacements(deformer.lattice(), out));
  dragged(deformer, {300, 0, 0});
  deformer.cancel_stroke();
  EXPECT_TRUE(same_displacements(deformer.lattice(), out));
}

TEST(DeformerExtremes, HandlesOnAnchors) {
  Deformer deformer = row_of(40, {face_low_x, false});
  ASSERT_TRUE(deformer.begin_stroke({0, 0, 0}, 0).ok());
  const DragReport held = dragged(deformer, {-3, 1e6, 0});
  EXPECT_TRUE(held.clamped);
  EXPECT_EQ(held.moved_by_voxels, glm::dvec3(0));
  EXPECT_EQ(held.elements_moved, 0);
  EXPECT_TRUE(deformer.lattice().at_rest());
  deformer.end_stroke();
  // Of a ball over the anchor the free part moves: one link lets it by a quarter.
  deformer.release_all();
  const DragReport part = stroke(deformer, {0, 0, 0}, {3, 0, 0}, 2);
  EXPECT_TRUE(part.clamped);
  EXPECT_EQ(part.moved_by_voxels, glm::dvec3(0.25, 0, 0));
  EXPECT_EQ(deformer.lattice().u({0, 0, 0}), glm::ivec3(0));
  EXPECT_EQ(deformer.lattice().u({2, 0, 0}), glm::ivec3(128, 0, 0));
  // A pinned handle is no anchor to who grabs it.
  const DragReport again = stroke(deformer, {2, 0, 0}, {-0.25, 0, 0});
  EXPECT_FALSE(again.clamped);
  EXPECT_TRUE(deformer.lattice().at_rest());
}

TEST(DeformerExtremes, HandlesInCarvedHoles) {
  const Size3 size{40, 34, 34};
  Deformer deformer(constant_volume(size), table({material(0, 1, 0.5, 1.25, 0.125)}), {});
  const VoxelIndex hole{20, 31, 16};
  ASSERT_TRUE(deformer.carve(glm::dvec3(hole), 2).ok());
  const auto refused = deformer.begin_stroke(hole, 1);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().kind, ErrorKind::usage);
  EXPECT_NE(refused.error().message.find("(20, 31, 16) is carved away"), std::string::npos)
      << refused.error().message;
  EXPECT_FALSE(deformer.in_stroke());
  // The rim is grabbed around the hole, and what is carved stays.
  ASSERT_TRUE(deformer.begin_stroke(hole, 3).ok());
  EXPECT_FALSE(dragged(deformer, {2, 0, -1}).clamped);
  EXPECT_EQ(deformer.lattice().u(hole), glm::ivec3(0));
  EXPECT_EQ(deformer.lattice().u(hole + 1), glm::ivec3(0));
  EXPECT_EQ(deformer.lattice().u(hole + VoxelIndex(3, 0, 0)), glm::ivec3(2 * kVoxel, 0, -kVoxel));
  EXPECT_EQ(violated(deformer), 0);
  deformer.end_stroke();
  // A handle that is carved away after it was pinned can be dragged no more.
  deformer.release_all();
  const VoxelIndex pin{8, 8, 8};
  stroke(deformer, pin, {0.5, 0, 0}, 1);
  ASSERT_TRUE(deformer.carve(glm::dvec3(pin), 3).ok());
  EXPECT_FALSE(deformer.begin_stroke(pin, 1).ok());
  // Nor does it hold anything: its links are gone.
  EXPECT_FALSE(stroke(deformer, pin + VoxelIndex(5, 0, 0), {30, 0, 0}).clamped);
  EXPECT_EQ(violated(deformer), 0);
}

// A table that makes the lattice as it lies violated: the next stroke makes no link worse, and
// equals Dijkstra's algorithm from there.
TEST(DeformerExtremes, MaterialEditsBetweenStrokes) {
  const Size3 size{40, 34, 20};
  const auto soft = table({material(0, 1, 0.2, 3, 1), material(1, 2, 0.5, 101, 100)});
  const auto stiff = table({material(0, 1, 0.9, 1.1, 0.05), material(1, 2, 1, 1, 0)});
  Deformer deformer(random_volume(size, 2, 3, 19), soft, {});
  stroke(deformer, {20, 17, 10}, {12, -30, 4});
  deformer.release_all();
  const Lattice start = deformer.lattice();
  const auto continued = [&] {
    const VoxelIndex handle{10, 30, 3};
    const DragReport report = stroke(deformer, handle, {-8, 70, 140});
    const Drag drag{deformer.materials(), start, {handle}};
    const ChainMailAnswer expected = exactly(drag, {-8 * kVoxel, 70 * kVoxel, 140 * kVoxel});
    EXPECT_TRUE(equal(expected.lattice, deformer.lattice()));
    EXPECT_EQ(report.elements_moved, expected.elements_moved);
    EXPECT_TRUE(deformer.undo());
    return expected.elements_moved;
  };
  const std::int64_t moved_soft = continued();
  ASSERT_TRUE(deformer.set_materials(stiff).ok());
  EXPECT_GT(violated(deformer), 0);
  const std::int64_t moved_stiff = continued();
  EXPECT_GT(moved_stiff, moved_soft);
  ASSERT_TRUE(deformer.undo());  // the edit
  EXPECT_EQ(violated(deformer), 0);
  EXPECT_EQ(continued(), moved_soft);
}

}  // namespace
}  // namespace maille
