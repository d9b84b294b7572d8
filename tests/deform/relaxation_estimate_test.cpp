// Whether what a relaxation says is left to equilibrium is true, and whether what it leaves out of
// its region matters.
#include <cmath>

#include <gtest/gtest.h>

#include "references/dense_problem.h"
#include "tests/deform/relaxing.h"

namespace maille {
namespace {

using testing::displacements_of;
using testing::distance_of;
using testing::for_each_voxel;
using testing::material;
using testing::RelaxationScene;
using testing::run;
using testing::workers;

struct Scene {
  const char* what;
  Size3 size;
  std::vector<double> stiffness;
  bool ball;  // of the second material; else blocks at random
  double radius;
  glm::dvec3 by_voxels;
};
std::ostream& operator<<(std::ostream& out, const Scene& s) { return out << s.what; }

// Dragged by ChainMail from rest, as a person does.
std::unique_ptr<RelaxationScene> dragged(const Scene& s) {
  const VoxelIndex middle = s.size / 2;
  std::vector<std::uint8_t> samples;
  for_each_voxel(s.size, [&](VoxelIndex v) {
    samples.push_back(s.ball && glm::length(glm::dvec3(v - middle)) <= s.radius + 2.0);
  });
  std::vector<Material> materials;
  for (std::size_t m = 0; m < s.stiffness.size(); ++m) {
    materials.push_back(material(static_cast<double>(m), static_cast<double>(m) + 1.0, 0.5, 1.6,
                                 0.24, s.stiffness[m]));
  }
  const int kinds = static_cast<int>(materials.size());
  auto scene = std::make_unique<RelaxationScene>(
      s.ball ? Volume::of(s.size, VoxelType::uint8, axis_aligned(glm::dvec3(1)), std::move(samples))
             : testing::random_volume(s.size, kinds, 3, 5),
      std::move(materials));
  scene->anchors = {};
  const ElementSet handle = ball_of_elements(middle, s.radius, scene->start.grid());
  StrokeBricks bricks(scene->field, scene->cuts, scene->held, scene->anchors);
  scene->start = solve_chainmail({scene->start, bricks, handle, 0},
                                 glm::ivec3(s.by_voxels * double{kUnitsPerVoxel}), workers())
                     .lattice;
  scene->held.insert(handle);
  return scene;
}

class RelaxationEstimate : public ::testing::TestWithParam<Scene> {};

// Within a factor of three when it first says a tenth, a hundredth, a thousandth of a voxel.
TEST_P(RelaxationEstimate, IsHonest) {
  const auto scene = dragged(GetParam());
  RelaxationOptions options;
  options.tolerance_voxels = 1e-4;
  // The equilibrium that relaxation goes to: where several are, it is not said which.
  Relaxation to_the_end = scene->relaxation(workers(2), options);
  run(to_the_end, 1000);
  SpringProblem twin = scene->twin();
  twin.start_voxels = to_the_end.displacements_voxels();
  const Equilibrium expected = spring_equilibrium(twin, workers(2));
  ASSERT_TRUE(expected.converged);
  ASSERT_LT(distance_of(twin.start_voxels, expected.u_voxels, twin.held).largest, 0.01);

  Relaxation relaxation = scene->relaxation(workers(2), options);
  for (const double target : {0.1, 0.01, 0.001}) {
    while (!relaxation.progress().finished() &&
           relaxation.progress().residual_rms_voxels > target) {
      relaxation.iterate();
    }
    const double said = relaxation.progress().residual_rms_voxels;
    EXPECT_LE(said, target);
    const double distance =
        distance_of(relaxation.displacements_voxels(), expected.u_voxels, twin.held).rms;
    EXPECT_LT(distance, 3.0 * said)
        << "it said " << said << " after " << relaxation.progress().iterations;
    EXPECT_GT(distance, said / 3.0)
        << "it said " << said << " after " << relaxation.progress().iterations;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, RelaxationEstimate,
    ::testing::Values(Scene{"homogeneous", Size3(21), {1}, false, 2.0, {2.0, 0.5, -0.3}},
                      Scene{"stiff ball", Size3(21), {1, 1000}, true, 1.5, {1.5, 0.5, -0.3}},
                      Scene{"turning ball", Size3(21), {1, 1e6}, true, 0.0, {0.6, 0.4, -0.3}},
                      Scene{"three materials", Size3(19), {1, 20, 400}, false, 2.0, {1.2, 0, 0.7}},
                      Scene{"thin sheet", {41, 37, 3}, {1}, false, 2.0, {0.5, 0.0, 2.0}},
                      Scene{"long bar", {60, 7, 7}, {1, 10}, false, 1.0, {1.5, 0.5, 0.0}}));

// --- turns

// A ball held at its middle alone turns in what is around it, however stiff it is: that takes no
// more than three times the cycles that one as soft takes.
TEST(StiffTurns, CostFewCycles) {
  std::int64_t cycles_alike = 0;
  for (const double ratio : {1.0, 1e2, 1e4, 1e9}) {
    const auto scene = dragged({"ball", Size3(25), {1, ratio}, true, 0.0, {0.6, 0.4, -0.3}});
    RelaxationOptions options;
    options.tolerance_voxels = 0.001;
    Relaxation relaxation = scene->relaxation(workers(2), options);
    run(relaxation, 200);
    EXPECT_TRUE(relaxation.progress().converged) << ratio;
    if (ratio == 1.0) cycles_alike = relaxation.progress().iterations;
    EXPECT_LE(relaxation.progress().iterations, 3 * cycles_alike) << ratio;
    const SpringProblem twin = scene->twin();
    const Equilibrium expected = spring_equilibrium(twin, workers(2));
    ASSERT_TRUE(expected.converged);
    EXPECT_LT(distance_of(relaxation.displacements_voxels(), expected.u_voxels, twin.held).largest,
              0.005)
        << ratio;
  }
}

// --- the region

Scene in_the_large() { return {"in the large", Size3(54), {1, 5}, false, 1.0, {0.9, 0.3, 0.0}}; }

// A region that grows as it has to ends where the whole volume would.
TEST(RelaxationRegion, EndsWhereTheWholeVolumeDoes) {
  const auto scene = dragged(in_the_large());
  RelaxationOptions options;
  options.tolerance_voxels = 0.01;
  Relaxation growing = scene->relaxation(workers(2), options);
  const auto free_first = growing.progress().free_elements;
  EXPECT_LT(free_first, voxel_count(scene->size()) / 2);
  struct Said {
    double residual_voxels;
    std::vector<glm::dvec3> u_voxels;
  };
  std::vector<Said> said;
  while (!growing.progress().finished()) {
    growing.iterate();
    ASSERT_LT(growing.progress().iterations, 500);
    if (growing.progress().residual_voxels < 0.1) {
      said.push_back({growing.progress().residual_voxels, growing.displacements_voxels()});
    }
  }
  EXPECT_TRUE(growing.progress().converged);
  EXPECT_FALSE(growing.progress().region_limited);
  Relaxation whole(scene->start, scene->field, scene->cuts, scene->held, scene->anchors, workers(2),
                   options, VoxelBox{VoxelIndex(0), scene->size()});
  EXPECT_GT(whole.progress().free_elements, free_first);
  run(whole, 500);
  EXPECT_TRUE(whole.progress().converged);
  const SpringProblem twin = scene->twin();
  EXPECT_LT(
      distance_of(growing.displacements_voxels(), whole.displacements_voxels(), twin.held).largest,
      2 * options.tolerance_voxels + 0.002);
  // What it says on its way counts what lies beyond the region.
  EXPECT_GT(said.size(), 2u);
  for (const Said& one : said) {
    EXPECT_LT(distance_of(one.u_voxels, whole.displacements_voxels(), twin.held).largest,
              3.0 * one.residual_voxels);
  }
}

// With less memory than what is pulled would take, it says so, and what lies further out holds.
TEST(RelaxationRegion, IsLimitedByMemoryAndSaysSo) {
  const auto scene = dragged(in_the_large());
  RelaxationOptions options;
  options.memory_bytes = 64 * 20 * 20 * 20;
  Relaxation relaxation = scene->relaxation(workers(2), options);
  run(relaxation, 500);
  EXPECT_TRUE(relaxation.progress().finished());
  EXPECT_TRUE(relaxation.progress().region_limited);
  EXPECT_LE(relaxation.progress().free_elements, 20 * 20 * 20);
  EXPECT_GT(relaxation.progress().free_elements, 14 * 14 * 14);
  const Lattice lattice = relaxation.lattice();
  VoxelBox moved{scene->size(), VoxelIndex(0)};
  for_each_voxel(scene->size(), [&](VoxelIndex v) {
    if (lattice.u(v) == scene->start.u(v)) return;
    moved.lo = glm::min(moved.lo, v);
    moved.hi = glm::max(moved.hi, v + 1);
  });
  EXPECT_FALSE(moved.empty());
  EXPECT_LE(voxel_count(moved.size()), 20 * 20 * 20);
}

// What it promised to take: 64 bytes an element, and what little a box has around it.
TEST(RelaxationRegion, TakesWhatItSaysAndNoMore) {
  const auto scene = dragged(in_the_large());
  Relaxation whole(scene->start, scene->field, scene->cuts, scene->held, scene->anchors, workers(2),
                   {}, VoxelBox{VoxelIndex(0), scene->size()});
  EXPECT_LE(whole.bytes(), 64 * voxel_count(scene->size()) * 5 / 4);
}

}  // namespace
}  // namespace maille
