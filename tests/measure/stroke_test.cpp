#include "measure/stroke.h"

#include <gtest/gtest.h>

#include "measure/drag_scene.h"

namespace maille {
namespace {

constexpr double kPlane = 2.0;  // bytes an element of a component

// Bytes an element, each within what bricks and planes cost beside their arrays.
constexpr double kBeside = 0.2;

TEST(StrokeMemory, FromRestIsTheAnswerAlone) {
  const DragScene scene =
      uniform_scene("s", "s", Size3(64), octahedron_of(20'000), {1.0, -0.9, 0.8});
  Deformer deformer = scene.deformer();
  WorkerPool pool(1);
  EXPECT_EQ(deformer.stroke_memory().lattice_bytes, 0);
  ASSERT_TRUE(deformer.begin_stroke(scene.grab.element, 0.0).ok());
  const auto first = timed_drag(deformer, scene.grab.by_voxels, pool);
  ASSERT_TRUE(first.ok());
  EXPECT_EQ((*first).peak.lattice_bytes, 0);
  EXPECT_EQ((*first).memory.elements, 64 * 64 * 64);
  EXPECT_NEAR(bytes_per_element((*first).memory), 3 * kPlane, kBeside);
  EXPECT_NEAR(bytes_per_element((*first).peak), 3 * kPlane, kBeside);
  const auto next = timed_drag(deformer, scene.grab.by_voxels, pool);
  ASSERT_TRUE(next.ok());
  EXPECT_NEAR(bytes_per_element((*next).memory), 3 * kPlane, kBeside);
  EXPECT_NEAR(bytes_per_element((*next).peak), 3 * kPlane, kBeside);
  deformer.end_stroke();
  EXPECT_EQ(deformer.stroke_memory().lattice_bytes, 0);
}

TEST(StrokeMemory, WhatHasMovedBeforeIsKeptBesideTheAnswerWhereItDiffers) {
  const DragScene scene = moved_again_scene(32, 1);
  Deformer deformer = scene.deformer();
  WorkerPool pool(1);
  ASSERT_TRUE(scene.play_before(deformer, pool).ok());
  ASSERT_TRUE(deformer.begin_stroke(scene.grab.element, 0.0).ok());
  // A byte an element is of the material. One component: the other two planes are shared.
  const auto one = timed_drag(deformer, {scene.grab.by_voxels.x, 0.0, 0.0}, pool);
  ASSERT_TRUE(one.ok());
  EXPECT_NEAR(bytes_per_element((*one).memory), 4 * kPlane + 1.0, 0.5);
  const auto all = timed_drag(deformer, scene.grab.by_voxels, pool);
  ASSERT_TRUE(all.ok());
  EXPECT_NEAR(bytes_per_element((*all).memory), 6 * kPlane + 1.0, 0.5);
  const auto again = timed_drag(deformer, scene.grab.by_voxels, pool);
  ASSERT_TRUE(again.ok());
  EXPECT_NEAR(bytes_per_element((*again).peak), 6 * kPlane + 1.0, 0.5);
}

}  // namespace
}  // namespace maille
