// The solver at the ends of what it may be given, against formulas and Dijkstra's algorithm.
#include <algorithm>
#include <cstdlib>
#include <random>

#include <gtest/gtest.h>

#include "deform/chainmail.h"
#include "deform/cuts_edit.h"
#include "tests/deform/dense_twin.h"

namespace maille {
namespace {

using testing::constant_volume;
using testing::Drag;
using testing::equal;
using testing::exactly;
using testing::expect_displacements;
using testing::for_each_voxel;
using testing::material;
using testing::random_lattice;
using testing::random_volume;
using testing::table;

constexpr int kVoxel = kUnitsPerVoxel;
constexpr int kMost16Bits = 65535;

// From exactly 1 to slack of 100 voxels, by rising value.
std::vector<Material> rigid_to_hundredfold() {
  return {material(0, 1, 1, 1, 0), material(1, 2, 0.99, 1.01, 0.01), material(2, 3, 0, 101, 100),
          material(3, 4, 0.5, 2, 0.5)};
}

// How far an element must move in one material from rest: what the links of a shortest way to the
// handle leave of the drag.
int left_of(int drag, glm::ivec3 away, int component, const MaterialTable& one) {
  const ElementLimits& limits = one.limits(0);
  int used = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const bool ahead = (away[axis] > 0) == (drag > 0);
    const int slack = axis != component ? limits.shear[component]
                      : ahead           ? limits.compress[component]
                                        : limits.stretch[component];
    used += std::abs(away[axis]) * slack;
  }
  return std::max(0, std::abs(drag) - used) * (drag > 0 ? 1 : -1);
}

TEST(ChainMailExtremes, RigidBesideAHundredVoxelsOfSlackInRandomVoxels) {
  const Size3 size{45, 37, 34};
  const MaterialField field(random_volume(size, 4, 1, 21), table(rigid_to_hundredfold()));
  const Lattice rest(size);
  const Drag free{field, rest, {{22, 20, 31}}};
  exactly(free, {60 * kVoxel, -20 * kVoxel, 5 * kVoxel});
  exactly(free, {-300 * kVoxel, 0, 130 * kVoxel});
  const Drag anchored{field, rest, {{22, 20, 31}}, {}, {face_low_x, false}};
  const ChainMailAnswer held = exactly(anchored, {-300 * kVoxel, 700 * kVoxel, 0});
  EXPECT_TRUE(held.clamped);
}

// The largest drag of 16-bit labels and the smallest of 32 bits, and the same for limits.
TEST(ChainMailExtremes, WhereLabelsOutgrow16Bits) {
  const Size3 size{40, 33, 9};
  const Lattice rest(size);
  for (const int slack : {100 * kVoxel, kMost16Bits, kMost16Bits + 1, 150 * kVoxel}) {
    SCOPED_TRACE(slack);
    auto materials = rigid_to_hundredfold();
    const double voxels = static_cast<double>(slack) / kVoxel;
    materials[2] = material(2, 3, 0, 1 + voxels, voxels);
    const MaterialField field(random_volume(size, 4, 1, 5), table(materials));
    ASSERT_EQ(field.table().limits(2).stretch.x, slack);
    const Drag drag{field, rest, {{33, 31, 4}, {1, 1, 1}}};
    for (const int by : {kVoxel, kMost16Bits - 1, kMost16Bits, kMost16Bits + 1, 2 * kMost16Bits}) {
      SCOPED_TRACE(by);
      exactly(drag, {by, 0, -by});
    }
  }
}

TEST(ChainMailExtremes, WithoutShearWholeLayersMoveAsOne) {
  const Size3 size{40, 33, 31};
  const MaterialField field(constant_volume(size), table({material(0, 1, 0.5, 1.25, 0)}));
  const Lattice rest(size);
  const VoxelIndex handle{7, 32, 0};
  const glm::ivec3 by{-6 * kVoxel, 3 * kVoxel, 0};
  const ChainMailAnswer answer = exactly({field, rest, {handle}}, by);
  expect_displacements(answer.lattice, [&](VoxelIndex v) {
    return glm::ivec3(left_of(by.x, {v.x - handle.x, 0, 0}, 0, field.table()),
                      left_of(by.y, {0, v.y - handle.y, 0}, 1, field.table()), 0);
  });
}

TEST(ChainMailExtremes, RigidAllOverMovesTheWholeVolumeByAnything) {
  const Size3 size{33, 40, 65};
  const MaterialField field(constant_volume(size), table({material(0, 1, 1, 1, 0)}));
  const Lattice rest(size);
  for (const glm::ivec3 by : {glm::ivec3(1, 0, -1), glm::ivec3(70000, -3, 1 << 29)}) {
    const ChainMailAnswer answer = Drag{field, rest, {{32, 0, 64}}}.by(by);
    expect_displacements(answer.lattice, [&](VoxelIndex) { return by; });
    EXPECT_EQ(answer.elements_moved, voxel_count(size));
    EXPECT_EQ(answer.moved_by, by);
  }
}

TEST(ChainMailExtremes, ASingleVoxel) {
  const Size3 size{1, 1, 1};
  const MaterialField field(constant_volume(size), table({material(0, 1, 0.5, 1.5, 0.2)}));
  const Lattice rest(size);
  const glm::ivec3 by{-5, 1 << 20, 3};
  const ChainMailAnswer answer = exactly({field, rest, {{0, 0, 0}}}, by);
  EXPECT_EQ(answer.lattice.u({0, 0, 0}), by);
  EXPECT_EQ(answer.elements_moved, 1);
  const ChainMailAnswer back = exactly({field, answer.lattice, {{0, 0, 0}}}, -by);
  EXPECT_TRUE(back.lattice.at_rest());
  const ChainMailAnswer held = exactly({field, rest, {{0, 0, 0}}, {{0, 0, 0}}}, by);
  EXPECT_EQ(held.moved_by, glm::ivec3(0));
  EXPECT_TRUE(held.lattice.at_rest());
}

// Slabs of one voxel, single rows, and borders one short of a brick's end, on it and one beyond.
TEST(ChainMailExtremes, ThinVolumesAndBordersWithinBricks) {
  std::mt19937 random(77);
  for (const Size3 size : {Size3{1, 40, 45},
                           {40, 1, 45},
                           {40, 45, 1},
                           {97, 1, 1},
                           {1, 97, 1},
                           {1, 1, 97},
                           {31, 33, 5},
                           {32, 31, 6},
                           {33, 32, 4},
                           {63, 4, 33},
                           {65, 5, 31},
                           {5, 65, 32},
                           {4, 33, 65},
                           {33, 33, 33}}) {
    SCOPED_TRACE(::testing::Message() << size.x << 'x' << size.y << 'x' << size.z);
    const MaterialField field(random_volume(size, 4, 2, 8), table(rigid_to_hundredfold()));
    const MaterialField single(constant_volume(size), table({material(0, 1, 0.4, 1.7, 0.3)}));
    const Lattice rest(size);
    for (const MaterialField* one : {&field, &single}) {
      const auto somewhere = [&] {
        return VoxelIndex(random() % static_cast<unsigned>(size.x),
                          random() % static_cast<unsigned>(size.y),
                          random() % static_cast<unsigned>(size.z));
      };
      const glm::ivec3 by{-17 * kVoxel, 11 * kVoxel, 23 * kVoxel};
      const ChainMailAnswer first = exactly({*one, rest, {somewhere()}}, by);
      exactly({*one, first.lattice, {somewhere()}, {}, {face_high_y, false}}, -2 * by);
      exactly({*one, first.lattice, {size - 1}}, {150 * kVoxel, 1, -150 * kVoxel});
    }
  }
}

TEST(ChainMailExtremes, HandlesOnTheBorder) {
  const Size3 size{34, 33, 65};
  const MaterialField field(random_volume(size, 4, 3, 9), table(rigid_to_hundredfold()));
  const Lattice rest(size);
  const glm::ivec3 by{9 * kVoxel, 8 * kVoxel, 7 * kVoxel};
  for (const VoxelIndex corner : {VoxelIndex(0, 0, 0), size - 1, VoxelIndex(0, size.y - 1, 40)}) {
    exactly({field, rest, {corner}}, by);
    exactly({field, rest, {corner}}, -by);
  }
}

TEST(ChainMailExtremes, ADragOfNoUnitsChangesNothing) {
  const Size3 size{40, 40, 10};
  const MaterialField field(constant_volume(size), table({material(0, 1, 1, 1, 0)}));
  const Lattice start = Drag{field, Lattice(size), {{3, 3, 3}}}.by({700, 0, 0}).lattice;
  const ChainMailAnswer nothing = Drag{field, start, {{3, 3, 3}}}.by({0, 0, 0});
  EXPECT_EQ(nothing.elements_moved, 0);
  EXPECT_EQ(nothing.bricks_swept, 0);
  EXPECT_FALSE(nothing.clamped);
  Lattice::for_each_difference(nothing.lattice, start, [](std::int64_t b) { ADD_FAILURE() << b; });
  const ChainMailAnswer nobody = Drag{field, start, {}}.by({512, 512, 512});
  EXPECT_EQ(nobody.elements_moved, 0);
  EXPECT_TRUE(equal(nobody.lattice, start));
}

// The smallest drag there is: one unit moves what is rigidly joined and nothing else.
TEST(ChainMailExtremes, OneUnit) {
  const Size3 size{40, 40, 10};
  const MaterialField field(random_volume(size, 2, 8, 4),
                            table({material(0, 1, 1, 1, 0), material(1, 2, 0.9, 1.1, 0.1)}));
  const Lattice rest(size);
  exactly({field, rest, {{20, 20, 5}}}, {1, -1, 0});
  exactly({field, rest, {{5, 3, 9}, {34, 34, 1}}}, {0, 0, -1});
}

// Displacements further than 64 voxels apart within a brick, out of and back to 16 bits.
TEST(ChainMailExtremes, StartsFarFromRest) {
  const Size3 size{40, 36, 10};
  // One in five is rigid: too few to join into one piece.
  const MaterialField field(
      random_volume(size, 5, 1, 33),
      table({material(0, 1, 1, 1, 0), material(1, 2, 0, 31, 30), material(2, 3, 0, 101, 100),
             material(3, 4, 0.9, 61, 60), material(4, 5, 0.3, 100, 99)}));
  Lattice lattice = exactly({field, Lattice(size), {{5, 5, 5}}}, {0, 900 * kVoxel, 40}).lattice;
  lattice = exactly({field, lattice, {{35, 30, 2}}}, {20, -700 * kVoxel, 0}).lattice;
  const DisplacementPlane* wide = nullptr;
  lattice.for_each_brick([&](std::int64_t, const LatticeBrick& brick) {
    const auto& plane = brick.plane(1);
    if (plane && plane->highest() - plane->lowest() > kMost16Bits) wide = plane.get();
  });
  ASSERT_NE(wide, nullptr);
  exactly({field, lattice, {{20, 20, 5}, {3, 35, 0}}}, {-300, 5 * kVoxel, 20 * kVoxel});
  exactly({field, lattice, {{33, 20, 5}}, {{5, 5, 5}}}, {800 * kVoxel, -90 * kVoxel, 0});
}

// As relaxation of a torn lattice might leave it: hardly a link is within its limits.
TEST(ChainMailExtremes, StartsThatAreViolatedAllOver) {
  std::mt19937 random(12);
  for (const int most : {200, 30 * kVoxel, 300 * kVoxel, 900'000 * kVoxel}) {
    SCOPED_TRACE(most);
    const Size3 size{35, 33, 34};
    const MaterialField field(random_volume(size, 4, 1, 3), table(rigid_to_hundredfold()));
    const Lattice start = random_lattice(size, most, 0.3, random);
    exactly({field, start, {{31, 31, 31}, {2, 2, 2}}}, {4000, -77, -70000});
    exactly({field, start, {{34, 1, 20}}, {{1, 30, 30}}}, {-90 * kVoxel, 0, 90'000 * kVoxel});
  }
}

TEST(ChainMailExtremes, HandlesOfManyElementsAcrossBricks) {
  const Size3 size{70, 34, 35};
  const MaterialField field(random_volume(size, 4, 2, 14), table(rigid_to_hundredfold()));
  const Lattice rest(size);
  std::vector<VoxelIndex> layer, scattered, all;
  std::mt19937 random(2);
  for_each_voxel(size, [&](VoxelIndex v) {
    all.push_back(v);
    if (v.x == 32) layer.push_back(v);
    if (random() % 300 == 0) scattered.push_back(v);
  });
  const glm::ivec3 by{5 * kVoxel, -3 * kVoxel, 140 * kVoxel};
  exactly({field, rest, layer}, by);
  exactly({field, rest, scattered}, by);
  const Lattice moved = exactly({field, rest, all}, by).lattice;
  expect_displacements(moved, [&](VoxelIndex) { return by; });
  EXPECT_TRUE(exactly({field, moved, all}, -by).lattice.at_rest());
}

// Links from the last layer of a brick to a held first layer of the next: the drag is given up
// to the unit whichever brick holds.
TEST(ChainMailExtremes, PinnedElementsInAnotherBrick) {
  const Size3 size{66, 8, 8};
  const MaterialField field(random_volume(size, 3, 1, 6), table(rigid_to_hundredfold()));
  const Lattice rest(size);
  for (const int pin : {0, 31, 32, 33, 63, 64, 65}) {
    SCOPED_TRACE(pin);
    const VoxelIndex handle{pin < 40 ? 60 : 3, 4, 4};
    const Drag drag{field, rest, {handle}, {{pin, 2, 5}}};
    const glm::ivec3 by{-400 * kVoxel, 9000 * kVoxel, 20};
    const ChainMailAnswer answer = exactly(drag, by);
    EXPECT_TRUE(answer.clamped);
    EXPECT_EQ(answer.lattice.u({pin, 2, 5}), glm::ivec3(0));
    // Asking for no more than that is not held back.
    EXPECT_FALSE(exactly(drag, answer.moved_by).clamped);
  }
}

TEST(ChainMailExtremes, TwoHandlesPulledApartStopEachOther) {
  const Size3 size{50, 20, 33};
  const MaterialField field(random_volume(size, 4, 2, 31), table(rigid_to_hundredfold()));
  const VoxelIndex a{10, 10, 16};
  const VoxelIndex b{40, 10, 16};
  const glm::ivec3 by{-3000 * kVoxel, 0, 2000 * kVoxel};
  const ChainMailAnswer first = exactly({field, Lattice(size), {a}}, {-70 * kVoxel, 0, 512});
  const ChainMailAnswer second = exactly({field, first.lattice, {b}, {a}}, -by);
  EXPECT_TRUE(second.clamped);
  EXPECT_EQ(second.lattice.u(a), first.lattice.u(a));
  EXPECT_EQ(second.lattice.u(b), first.lattice.u(b) + second.moved_by);
  const ChainMailAnswer third = exactly({field, second.lattice, {a}, {b}}, by);
  EXPECT_EQ(third.moved_by, glm::ivec3(0));  // nothing is left to give
}

TEST(ChainMailExtremes, MaterialsOf256Levels) {
  const Size3 size{40, 33, 31};
  std::vector<std::uint8_t> samples;
  std::mt19937 random(64);
  for_each_voxel(size, [&](VoxelIndex v) {
    const int value = 5 * v.x + 3 * v.y - 2 * v.z + static_cast<int>(random() % 30);
    samples.push_back(static_cast<std::uint8_t>(std::clamp(value, 0, 255)));
  });
  auto soft = material(0, 100, 0.1, 4, 2);
  soft.stretch = {9, 1.5, 60};
  auto interpolated =
      MaterialTable::create({soft, material(100, 200, 0.9, 1.1, 0.05), material(200, 256, 1, 1, 0)},
                            Interpolation::linear);
  ASSERT_TRUE(interpolated.ok());
  ASSERT_GT(interpolated->count(), 100);
  const MaterialField field(
      Volume::of(size, VoxelType::uint8, axis_aligned(glm::dvec3(1)), std::move(samples)),
      *std::move(interpolated));
  const ChainMailAnswer first =
      exactly({field, Lattice(size), {{6, 20, 20}}}, {30 * kVoxel, 7 * kVoxel, -9 * kVoxel});
  exactly({field, first.lattice, {{35, 5, 8}}}, {-9 * kVoxel, 0, 160 * kVoxel});
}

TEST(ChainMailExtremes, LimitsThatDifferByAxis) {
  const Size3 size{64, 48, 40};
  Material m = material(0, 1, 1, 1, 0);
  m.compress = {0.9, 0.5, 0.0};
  m.stretch = {1.0, 1.5, 3.0};
  m.shear = {0.0, 0.1, 0.7};
  const MaterialField one(constant_volume(size), table({m}));
  const VoxelIndex handle{40, 31, 8};
  for (const glm::ivec3 by : {glm::ivec3(300, 1500, 9000), glm::ivec3(-300, -1500, -9000)}) {
    const ChainMailAnswer answer = Drag{one, Lattice(size), {handle}}.by(by);
    expect_displacements(answer.lattice, [&](VoxelIndex v) {
      glm::ivec3 u;
      for (int c = 0; c < 3; ++c) u[c] = left_of(by[c], v - handle, c, one.table());
      return u;
    });
  }
  Material other = material(1, 2, 1, 1, 0);
  other.compress = {0.0, 1.0, 0.3};
  other.stretch = {101, 1.25, 1.0};
  other.shear = {100, 0.0, 0.01};
  const Size3 small{40, 33, 17};
  const MaterialField two(random_volume(small, 2, 1, 44), table({m, other}));
  const Drag drag{two, Lattice(small), {{33, 3, 3}}};
  exactly(drag, {90 * kVoxel, -4 * kVoxel, 14 * kVoxel});
}

// What all links are gone of moves by itself, and what is left of a handle's links counts.
TEST(ChainMailExtremes, IslandsAndHandlesAtCuts) {
  const Size3 size{40, 34, 20};
  const MaterialField field(random_volume(size, 4, 2, 17), table(rigid_to_hundredfold()));
  const VoxelIndex island{31, 10, 10};
  CutsEdit edit{Cuts(size)};
  for_each_link(island, size, [&](VoxelIndex lower, int axis, VoxelIndex) {
    edit.set_removed(lower, axis, true);
  });
  for (int y = 0; y < size.y; ++y) {
    for (int z = 0; z < size.z; ++z) edit.set_removed({31, y, z}, 0, true);
  }
  Drag drag{field, Lattice(size), {island}};
  drag.cuts = edit.finish();
  const glm::ivec3 by{-1000 * kVoxel, 1 << 28, kMost16Bits};
  const ChainMailAnswer alone = exactly(drag, by);
  EXPECT_EQ(alone.elements_moved, 1);
  EXPECT_EQ(alone.lattice.u(island), by);
  drag.handle = {{31, 20, 10}};
  const ChainMailAnswer one_side = exactly(drag, {-60 * kVoxel, 60 * kVoxel, 0});
  for_each_voxel(size, [&](VoxelIndex v) {
    if (v.x > 31) {
      ASSERT_EQ(one_side.lattice.u(v), glm::ivec3(0));
    }
  });
}

}  // namespace
}  // namespace maille
