// The references against answers known on paper, against each other and against the product's own
// checks.
#include <algorithm>
#include <cstdlib>
#include <random>

#include <gtest/gtest.h>

#include "deform/deformer.h"
#include "measure/drag_scene.h"
#include "references/dense_checks.h"
#include "references/enhanced_chainmail.h"
#include "references/exact_dijkstra.h"
#include "references/fifo_chainmail.h"
#include "resample/resampler.h"

namespace maille {
namespace {

DenseProblem uniform_problem(Size3 size, Material material, VoxelIndex grabbed, glm::ivec3 by) {
  const auto count = static_cast<std::size_t>(voxel_count(size));
  DenseProblem problem;
  problem.size = size;
  problem.materials = {std::move(material)};
  problem.ids.assign(count, 0);
  problem.start.assign(count, glm::ivec3(0));
  problem.handle = {grabbed};
  problem.by = by;
  return problem;
}

DenseProblem random_problem(unsigned seed) {
  std::mt19937 random(seed);
  DenseProblem problem =
      uniform_problem({24, 20, 22}, three_tissues()[0], {12, 9, 11}, {3000, -1700, 900});
  problem.materials = three_tissues();
  for (auto& id : problem.ids) id = static_cast<MaterialId>(random() % 3);
  return problem;
}

// The same problem in the product's own form.
Lattice product_answer(const DenseProblem& problem, MaterialField& field, Deformer& deformer) {
  EXPECT_TRUE(deformer.begin_stroke(problem.handle.front(), 0.0).ok());
  WorkerPool pool(1);
  EXPECT_TRUE(deformer.drag_to(glm::dvec3(problem.by) / double{kUnitsPerVoxel}, pool).ok());
  EXPECT_EQ(field.size(), problem.size);
  return deformer.lattice();
}

TEST(References, AgreeOnPaperInOneMaterial) {
  // Half a voxel a link along the drag, an eighth across it: an octahedron a component.
  Material material = slack_material("m", 0, 0.5, 1);
  material.shear = glm::dvec3(0.125);
  const VoxelIndex grabbed{15, 13, 14};
  const DenseProblem problem = uniform_problem({31, 29, 30}, material, grabbed, {1500, -900, 300});
  std::vector<glm::ivec3> expected(problem.ids.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const glm::ivec3 away = glm::abs(voxel_of(i, problem.size) - grabbed);
    for (int c = 0; c < 3; ++c) {
      const int used = 64 * (away.x + away.y + away.z) + 192 * away[c];
      const int left = std::max(0, std::abs(problem.by[c]) - used);
      expected[i][c] = problem.by[c] < 0 ? -left : left;
    }
  }
  EXPECT_EQ(exact_dijkstra(problem).u, expected);
  EXPECT_EQ(enhanced_chainmail(problem).u, expected);
  EXPECT_EQ(fifo_chainmail(problem).u, expected);
  EXPECT_EQ(dense_violations(problem, expected).links, 0);
  EXPECT_EQ(dense_folded_cells(problem.size, expected), 0);
}

TEST(References, FirstInFirstOutBreaksLinksAroundAStiffBall) {
  const DragScene scene = stiff_ball_scene(48, {7, 3, -1.5});
  DenseProblem problem = uniform_problem(scene.volume.size(), scene.materials[0],
                                         scene.grab.element, {3584, 1536, -768});
  problem.materials = scene.materials;
  const auto samples = scene.volume.voxels<std::uint8_t>();
  problem.ids.assign(samples.begin(), samples.end());
  EXPECT_EQ(dense_violations(problem, exact_dijkstra(problem).u).links, 0);
  EXPECT_EQ(dense_violations(problem, enhanced_chainmail(problem).u).links, 0);
  const DenseViolations fifo = dense_violations(problem, fifo_chainmail(problem).u);
  EXPECT_GT(fifo.links, 100);
  EXPECT_GT(fifo.worst_voxels, 0.5);
}

TEST(References, EveryVisitOnceIsNotEnoughInMixedMaterial) {
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const DenseProblem problem = random_problem(seed);
    const DenseAnswer exact = exact_dijkstra(problem);
    EXPECT_EQ(dense_violations(problem, exact.u).links, 0);
    const DenseAnswer heap = enhanced_chainmail(problem);
    EXPECT_GT(dense_violations(problem, heap.u).links, 0);
    EXPECT_GT(dense_violations(problem, fifo_chainmail(problem).u).links, 0);
    // It never moves anything further than it must.
    for (std::size_t i = 0; i < heap.u.size(); ++i) {
      for (int c = 0; c < 3; ++c) ASSERT_LE(std::abs(heap.u[i][c]), std::abs(exact.u[i][c]));
    }
  }
}

// Along one axis one order serves all: the heap is Dijkstra.
TEST(References, TheHeapIsExactAlongOneAxis) {
  for (const unsigned seed : {5u, 6u, 7u}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    DenseProblem problem = random_problem(seed);
    problem.by = {0, -3000, 0};
    EXPECT_EQ(enhanced_chainmail(problem).u, exact_dijkstra(problem).u);
  }
}

TEST(References, WhatIsHeldStays) {
  DenseProblem problem =
      uniform_problem({30, 3, 3}, slack_material("m", 0, 0.25, 1), {20, 1, 1}, {10000, 0, 0});
  problem.held = {{10, 1, 1}};
  const DenseAnswer exact = exact_dijkstra(problem);
  EXPECT_EQ(exact.moved_by, glm::ivec3(1280, 0, 0));  // ten links, a quarter of a voxel each
  const std::size_t held = element_of({10, 1, 1}, problem.size);
  EXPECT_EQ(exact.u[held], glm::ivec3(0));
  for (const DenseAnswer& answer : {enhanced_chainmail(problem), fifo_chainmail(problem)}) {
    EXPECT_EQ(answer.moved_by, problem.by);
    EXPECT_EQ(answer.u[held], glm::ivec3(0));
    EXPECT_GT(dense_violations(problem, answer.u).links, 0);
  }
}

// The product and the references check alike.
TEST(References, ChecksAgreeWithTheProducts) {
  for (const double slack : {0.3, 0.8}) {
    DenseProblem problem = random_problem(9);
    problem.materials[0] = slack_material("a", 0, slack, 1);
    std::vector<std::uint8_t> samples(problem.ids.begin(), problem.ids.end());
    const Volume volume =
        Volume::of(problem.size, VoxelType::uint8, axis_aligned(glm::dvec3(1)), std::move(samples));
    const MaterialTable table = std::move(MaterialTable::create(problem.materials)).value();
    MaterialField field(volume, table);
    Deformer deformer(volume, table, {});
    const Lattice lattice = product_answer(problem, field, deformer);
    const DenseAnswer exact = exact_dijkstra(problem);
    for (std::size_t i = 0; i < exact.u.size(); ++i) {
      ASSERT_EQ(lattice.u(voxel_of(i, problem.size)), exact.u[i]);
    }
    WorkerPool pool(1);
    EXPECT_EQ(dense_folded_cells(problem.size, exact.u),
              count_folded_cells(lattice, Cuts(problem.size), pool));
    if (slack > 0.5) {
      EXPECT_GT(dense_folded_cells(problem.size, exact.u), 0);
    }
  }
}

}  // namespace
}  // namespace maille
