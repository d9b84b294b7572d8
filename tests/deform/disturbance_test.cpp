// What a deformer knows of its own equilibrium: which box a relaxation has to look at.
#include "deform/disturbance.h"

#include <gtest/gtest.h>

#include "deform/deformer.h"
#include "tests/deform/scenes.h"

namespace maille {
namespace {

using testing::constant_volume;
using testing::material;
using testing::table;
using testing::workers;

constexpr Size3 kSize{96, 64, 64};
constexpr double kTolerance = 0.01;

MaterialTable soft(double stiffness = 1.0) {
  return table({material(0, 1, 0.6, 1.5, 0.2, stiffness)});
}

bool holds(const VoxelBox& box, const VoxelBox& inside) { return united(box, inside) == box; }

// The box around all elements that lie elsewhere in b than in a, looked for one by one.
VoxelBox elements_that_differ(const Lattice& a, const Lattice& b) {
  VoxelBox box;
  for (int z = 0; z < kSize.z; ++z) {
    for (int y = 0; y < kSize.y; ++y) {
      for (int x = 0; x < kSize.x; ++x) {
        const VoxelIndex v{x, y, z};
        if (a.u(v) != b.u(v)) box = united(box, {v, v + 1});
      }
    }
  }
  return box;
}

class Disturbances : public ::testing::Test {
 protected:
  void drag(VoxelIndex from, glm::dvec3 by, const std::string& name = "") {
    ASSERT_TRUE(deformer_.begin_stroke(from, 2, name).ok());
    ASSERT_TRUE(deformer_.drag_to(by, workers()).ok());
    deformer_.end_stroke();
  }
  // As if a relaxation had found nothing to do.
  void settle(double within = kTolerance) { deformer_.adopt(deformer_.lattice(), within); }
  VoxelBox disturbed(double tolerance = kTolerance) const {
    const auto box = deformer_.relaxation_start(tolerance).disturbed;
    EXPECT_TRUE(box.has_value());
    return box.value_or(VoxelBox{});
  }

  Deformer deformer_{constant_volume(kSize), soft(), {}};
};

TEST(Boxes, UnitedCountsNoEmptyOne) {
  const VoxelBox a{{1, 2, 3}, {4, 5, 6}};
  EXPECT_EQ(united(a, {}), a);
  EXPECT_EQ(united({{9, 9, 9}, {0, 0, 0}}, a), a);
  EXPECT_EQ(united(a, {{0, 4, 4}, {1, 9, 5}}), (VoxelBox{{0, 2, 3}, {4, 9, 6}}));
}

TEST(Boxes, OfElements) {
  const BrickGrid grid(kSize);
  EXPECT_TRUE(box_of(ElementSet(), grid).empty());
  EXPECT_EQ(box_of(ball_of_elements({33, 31, 32}, 3, grid), grid),
            (VoxelBox{{30, 28, 29}, {37, 35, 36}}));
}

TEST_F(Disturbances, AtRestThereIsNone) {
  EXPECT_TRUE(disturbed().empty());
  ASSERT_TRUE(deformer_.carve({30, 30, 30}, 5).ok());
  EXPECT_TRUE(disturbed().empty()) << "springs at rest pull nothing, cut or not";
  ASSERT_TRUE(deformer_.set_materials(soft(2.0)).ok());
  EXPECT_TRUE(disturbed().empty());
}

TEST_F(Disturbances, ADragDisturbsWhatItMovesUntilThatHasRelaxed) {
  const Lattice before = deformer_.lattice();
  drag({20, 30, 30}, {3, 1, 0});
  const VoxelBox first = elements_that_differ(before, deformer_.lattice());
  EXPECT_TRUE(holds(disturbed(), first));
  settle();
  EXPECT_TRUE(disturbed().empty());
  const Lattice settled = deformer_.lattice();
  drag({75, 30, 30}, {0, 2, 0});
  EXPECT_TRUE(holds(disturbed(), elements_that_differ(settled, deformer_.lattice())));
  EXPECT_GT(disturbed().lo.x, 30) << "what the first one moved has relaxed";
}

TEST_F(Disturbances, AStrokeCountsFromWhereItBegan) {
  ASSERT_TRUE(deformer_.begin_stroke({20, 30, 30}, 2).ok());
  ASSERT_TRUE(deformer_.drag_to({8, 0, 0}, workers()).ok());
  const VoxelBox far = disturbed();
  settle();  // while the handle is held
  EXPECT_TRUE(disturbed().empty());
  ASSERT_TRUE(deformer_.drag_to({2, 0, 0}, workers()).ok());
  EXPECT_FALSE(disturbed().empty()) << "solved from button-down, which nothing has relaxed";
  EXPECT_TRUE(holds(far, disturbed()));
  deformer_.cancel_stroke();
  EXPECT_TRUE(disturbed().empty());
}

TEST_F(Disturbances, WhatAnUnfinishedRelaxationMovedIsDisturbed) {
  drag({20, 30, 30}, {3, 1, 0});
  Relaxation relaxation = deformer_.relax(workers(), {});
  relaxation.iterate();
  const Lattice before = deformer_.lattice();
  deformer_.adopt(relaxation.lattice());
  EXPECT_TRUE(holds(disturbed(), elements_that_differ(before, deformer_.lattice())));
}

TEST_F(Disturbances, ReleasesCutsAndMaterialsDisturb) {
  drag({20, 30, 30}, {3, 1, 0}, "a");
  drag({75, 30, 30}, {0, 3, 0}, "b");
  const VoxelBox moved = elements_that_differ(Lattice(kSize), deformer_.lattice());
  settle();
  ASSERT_TRUE(deformer_.release("b").ok());
  EXPECT_EQ(disturbed(), (VoxelBox{{73, 28, 28}, {78, 33, 33}}));
  settle();
  deformer_.release_all();
  EXPECT_EQ(disturbed(), (VoxelBox{{18, 28, 28}, {23, 33, 33}}));
  settle();
  ASSERT_TRUE(deformer_.carve({75, 33, 30}, 2).ok());
  EXPECT_TRUE(holds(disturbed(), {{74, 29, 29}, {77, 32, 32}}));
  EXPECT_GT(disturbed().lo.x, 60);
  settle();
  ASSERT_TRUE(deformer_.set_materials(soft(2.0)).ok());
  EXPECT_EQ(disturbed(), moved);
}

TEST_F(Disturbances, UndoBringsBackWhatWasKnown) {
  drag({20, 30, 30}, {3, 1, 0});
  const VoxelBox first = disturbed();
  drag({75, 30, 30}, {0, 3, 0});
  const VoxelBox both = disturbed();
  ASSERT_TRUE(deformer_.undo());
  EXPECT_EQ(disturbed(), first);
  ASSERT_TRUE(deformer_.redo());
  EXPECT_EQ(disturbed(), both);
  settle();  // belongs to the step before
  EXPECT_TRUE(disturbed().empty());
  ASSERT_TRUE(deformer_.undo());
  EXPECT_EQ(disturbed(), first);
  ASSERT_TRUE(deformer_.redo());
  EXPECT_TRUE(disturbed().empty());
}

TEST_F(Disturbances, AFinerToleranceLooksAtEverything) {
  drag({20, 30, 30}, {3, 1, 0});
  settle(0.1);
  EXPECT_TRUE(disturbed(0.1).empty());
  EXPECT_TRUE(disturbed(0.5).empty());
  EXPECT_FALSE(deformer_.relaxation_start(0.01).disturbed.has_value());
  settle(0.01);
  EXPECT_TRUE(disturbed(0.01).empty());
}

}  // namespace
}  // namespace maille
