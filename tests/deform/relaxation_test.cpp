#include "deform/relaxation.h"

#include <cmath>

#include <gtest/gtest.h>

#include "references/dense_problem.h"
#include "tests/deform/lattices.h"
#include "tests/deform/scenes.h"
#include "tests/deform/spring_twin.h"

namespace maille {
namespace {

using testing::constant_volume;
using testing::equal;
using testing::for_each_voxel;
using testing::lattice_of;
using testing::material;
using testing::random_volume;
using testing::spring_materials_of;
using testing::spring_twin;
using testing::table;
using testing::workers;

constexpr AnchorRules kFree{0, true};

RelaxationProgress run(Relaxation& relaxation, int most_iterations) {
  RelaxationProgress progress = relaxation.progress();
  for (int i = 0; i < most_iterations && !progress.converged; ++i) progress = relaxation.iterate();
  return progress;
}

// Two springs in series, of different stiffness, one end held and the other pulled by D: the middle
// settles at D k2 / (k1 + k2), where a spring between materials is two halves in series.
TEST(Relaxation, SpringPair) {
  const Size3 size{3, 1, 1};
  std::vector<std::uint8_t> samples{0, 0, 1};
  const MaterialField field(
      Volume::of(size, VoxelType::uint8, axis_aligned({0.7, 1, 1}), std::move(samples)),
      table({material(0, 1, 0.1, 9, 1, 2.0), material(1, 2, 0.1, 9, 1, 6.0)}));
  const double k1 = 2.0;
  const double k2 = 2.0 / (1.0 / 2.0 + 1.0 / 6.0);
  const int pull = 3 * kUnitsPerVoxel;
  const Lattice start = lattice_of(size, {{0, 0, 0}, {0, 0, 0}, {pull, 0, 0}});
  ElementSet held;
  held.insert({0, 0, 0}, start.grid());
  held.insert({2, 0, 0}, start.grid());
  WorkerPool pool(1);
  for (const double blend : {0.0, 0.25, 1.0}) {
    RelaxationOptions options;
    options.tolerance_voxels = 1e-4;
    options.rest_vector_blend = blend;
    Relaxation relaxation(start, field, Cuts(size), held, kFree, pool, options);
    const auto progress = run(relaxation, 1000);
    EXPECT_TRUE(progress.converged);
    EXPECT_FALSE(progress.energy_ever_rose);
    EXPECT_NEAR(relaxation.lattice().displacement_voxels({1, 0, 0}).x, 3.0 * k2 / (k1 + k2), 0.002);
  }
}

// A bar hung at one end and pulled at the other: each spring takes its share of the pull in
// proportion to its compliance.
TEST(Relaxation, HangingBar) {
  const int n = 45;  // crosses a brick border
  const Size3 size{1, 1, n};
  const Volume volume = random_volume(size, 3, 1, 11, {1, 1, 0.8});
  const std::vector<double> stiffness{1.0, 4.0, 20.0};
  const MaterialField field(volume,
                            table({material(0, 1, 0.1, 9, 1, 1.0), material(1, 2, 0.1, 9, 1, 4.0),
                                   material(2, 3, 0.1, 9, 1, 20.0)}));
  const auto compliance = [&](int z) {
    return 1.0 / stiffness[static_cast<std::size_t>(volume.value_at({0, 0, z}))];
  };
  const double pull = 6.0;

  std::vector<glm::ivec3> u(static_cast<std::size_t>(n), glm::ivec3(0));
  u.back().z = static_cast<int>(pull * kUnitsPerVoxel);
  const Lattice start = lattice_of(size, u);
  ElementSet held;
  held.insert({0, 0, 0}, start.grid());
  held.insert({0, 0, n - 1}, start.grid());
  WorkerPool pool(2);
  RelaxationOptions options;
  options.tolerance_voxels = 1e-3;
  Relaxation relaxation(start, field, Cuts(size), held, kFree, pool, options);
  const auto progress = run(relaxation, 200000);
  EXPECT_TRUE(progress.converged);
  EXPECT_FALSE(progress.energy_ever_rose);
  const Lattice lattice = relaxation.lattice();
  double total = 0.0;
  for (int z = 1; z < n; ++z) total += 0.5 * (compliance(z) + compliance(z - 1));
  double share = 0.0;
  for (int z = 1; z < n; ++z) {
    share += 0.5 * (compliance(z) + compliance(z - 1));
    EXPECT_NEAR(lattice.displacement_voxels({0, 0, z}).z, pull * share / total, 0.01) << z;
  }
}

class RelaxationReference : public ::testing::TestWithParam<int> {};

TEST_P(RelaxationReference, EndsAtNewtonsEquilibrium) {
  const int seed = GetParam();
  const Size3 size{9, 8, 7};
  const glm::dvec3 spacing_mm{1.0, 0.8, 1.5};
  const std::vector<double> stiffness{1.0, seed % 2 ? 10.0 : 100.0, 0.3};
  const Volume volume = random_volume(size, 3, 2, static_cast<unsigned>(seed), spacing_mm);
  Deformer deformer(volume,
                    table({material(0, 1, 0.5, 1.6, 0.24, stiffness[0]),
                           material(1, 2, 0.5, 1.6, 0.24, stiffness[1]),
                           material(2, 3, 0.5, 1.6, 0.24, stiffness[2])}),
                    {});
  ASSERT_TRUE(deformer.begin_stroke({4, 4, 3}, 1).ok());
  ASSERT_TRUE(deformer.drag_to({1.1, -0.4, 0.5}, workers()).ok());
  deformer.end_stroke();
  const ElementSet handle = ball_of_elements({4, 4, 3}, 1, deformer.lattice().grid());
  RelaxationOptions options;
  options.tolerance_voxels = 0.001;
  WorkerPool pool(2);
  Relaxation relaxation = deformer.relax(pool, options);
  const auto progress = run(relaxation, 100000);
  EXPECT_TRUE(progress.converged);
  EXPECT_FALSE(progress.energy_ever_rose);
  EXPECT_LE(progress.energy_last, progress.energy_first);
  SpringProblem problem =
      spring_twin(volume, spring_materials_of(stiffness, options.rest_vector_blend),
                  deformer.lattice(), Cuts(size));
  for_each_voxel(size, [&](VoxelIndex v) {
    problem.held[element_of(v, size)] =
        handle.contains(v, deformer.lattice().grid()) || faces_of(v, size) != 0;
  });
  const Equilibrium expected = spring_equilibrium(problem, pool);
  EXPECT_TRUE(expected.converged);
  const Lattice lattice = relaxation.lattice();
  double worst = 0.0;
  for_each_voxel(size, [&](VoxelIndex v) {
    const std::size_t i = element_of(v, size);
    worst = std::max(worst, glm::length(lattice.displacement_voxels(v) - expected.u_voxels[i]));
    if (problem.held[i]) {
      EXPECT_EQ(lattice.u(v), deformer.lattice().u(v));
    }
  });
  EXPECT_LT(worst, 0.005);  // tolerance, and rounding to 1/512 voxel
}

INSTANTIATE_TEST_SUITE_P(Seeds, RelaxationReference, ::testing::Range(1, 7));

TEST(Relaxation, SameBitsForAnyNumberOfThreads) {
  const Size3 size{80, 70, 66};
  const Volume volume = random_volume(size, 2, 5, 3);
  std::optional<Lattice> first;
  for (const int threads : {1, 2, 3, 8}) {
    Deformer deformer(
        volume, table({material(0, 1, 0.4, 2, 0.3, 1), material(1, 2, 0.9, 1.1, 0.05, 50)}), {});
    ASSERT_TRUE(deformer.begin_stroke({40, 35, 33}, 3).ok());
    ASSERT_TRUE(deformer.drag_to({0, -9, 4}, workers()).ok());
    WorkerPool pool(threads);
    Relaxation relaxation = deformer.relax(pool, {});
    run(relaxation, 40);
    const Lattice lattice = relaxation.lattice();
    if (!first) {
      first = lattice;
    } else {
      EXPECT_TRUE(equal(lattice, *first)) << threads << " threads";
    }
  }
}

// Pulled, let go and held by nothing but the border: everything springs back.
TEST(Relaxation, SpringsBackWhenReleased) {
  const Size3 size{24, 24, 24};
  Deformer deformer(constant_volume(size), table({material(0, 1, 0.5, 1.5, 0.24)}), {});
  ASSERT_TRUE(deformer.begin_stroke({12, 12, 12}, 1, "pull").ok());
  ASSERT_TRUE(deformer.drag_to({1.5, 0, 0}, workers()).ok());
  deformer.end_stroke();
  ASSERT_TRUE(deformer.release("pull").ok());
  WorkerPool pool(2);
  RelaxationOptions options;
  options.tolerance_voxels = 0.001;
  Relaxation relaxation = deformer.relax(pool, options);
  const auto progress = run(relaxation, 20000);
  EXPECT_TRUE(progress.converged);
  deformer.adopt(relaxation.lattice());
  for (int x = 0; x < size.x; ++x) {
    EXPECT_LT(glm::length(deformer.lattice().displacement_voxels({x, 12, 12})), 0.01);
  }
  ASSERT_TRUE(deformer.undo());
}

TEST(Relaxation, NothingToDoIsConverged) {
  const Size3 size{10, 10, 10};
  Deformer deformer(constant_volume(size), table({material(0, 1, 0.5, 1.5, 0.24)}), {});
  WorkerPool pool(1);
  Relaxation relaxation = deformer.relax(pool, {});
  EXPECT_TRUE(relaxation.iterate().converged);
  EXPECT_EQ(relaxation.progress().element_updates, 0);
  EXPECT_EQ(relaxation.bytes(), 0);
}

}  // namespace
}  // namespace maille
