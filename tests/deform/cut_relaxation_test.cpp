// Relaxation of a lattice that has been cut and carved.
#include <array>
#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "deform/carving.h"
#include "deform/cutting.h"
#include "deform/missing_springs.h"
#include "deform/relaxation.h"
#include "references/dense_problem.h"
#include "tests/deform/relaxing.h"

namespace maille {
namespace {

using testing::equal;
using testing::for_each_voxel;
using testing::kFree;
using testing::lattice_of;
using testing::material;
using testing::random_volume;
using testing::run;
using testing::spring_twin;
using testing::table;

// By the reference's own rule: see dense_springs.h.
bool spring_left(const DenseSprings& reference, VoxelIndex a, VoxelIndex b) {
  for (int s = 0; s < DenseSprings::kForward; ++s) {
    const glm::ivec3 offset = DenseSprings::kOffsets[static_cast<std::size_t>(s)];
    if (b - a == offset) return reference.has_spring(element_of(a, reference.size()), s);
    if (a - b == offset) return reference.has_spring(element_of(b, reference.size()), s);
  }
  ADD_FAILURE() << "no spring is that long";
  return false;
}

Cuts with_disc(const Cuts& cuts, const Lattice& lattice, glm::dvec3 center, glm::dvec3 normal,
               double radius) {
  const auto disc = CutSurface::disc(center, normal, radius, glm::dvec3(1));
  EXPECT_TRUE(disc.ok());
  auto cut = cut_along(cuts, lattice, *disc);
  EXPECT_TRUE(cut.ok());
  return std::move(cut).value();
}

TEST(MissingSprings, AreThoseWithoutAWay) {
  const Size3 size{40, 35, 34};
  const Lattice rest(size);
  const Springs springs = springs_of(glm::dvec3(1));
  Cuts cuts(size);
  for (std::int64_t b = 0; b < cuts.grid().count(); ++b) {
    EXPECT_TRUE(missing_springs(cuts, b, springs).empty());
  }
  cuts = with_disc(cuts, rest, {31.2, 20, 20}, {5, 1, 2}, 9.0);
  cuts = with_disc(cuts, rest, {20, 31.5, 31.5}, {1, 2, -2}, 9.0);
  cuts = carve(cuts, rest, {31, 31, 31}, 2.5);
  cuts = carve(cuts, rest, {0, 0, 0}, 1.0);
  WorkerPool pool(1);
  const SpringProblem twin =
      spring_twin(testing::constant_volume(size), {SpringMaterial{}}, rest, cuts);
  const DenseSprings reference(twin, pool);
  std::int64_t missing_in_all = 0;
  std::int64_t brick = -1;
  std::vector<std::uint32_t> missing;
  for_each_voxel(size, [&](VoxelIndex i) {
    const std::int64_t here = cuts.grid().linear(BrickGrid::brick_of(i));
    if (here != brick) missing = missing_springs(cuts, brick = here, springs);
    const std::uint32_t bits =
        missing.empty() ? 0 : missing[static_cast<std::size_t>(element_in_brick(i))];
    for (std::size_t s = 0; s < springs.size(); ++s) {
      const VoxelIndex j = i + springs[s].offset;
      if (!contains(size, j)) continue;  // no spring either way
      const bool expected = !spring_left(reference, i, j);
      missing_in_all += expected;
      ASSERT_EQ(((bits >> s) & 1) != 0, expected);
      if (cuts.carved(i)) {
        EXPECT_TRUE(expected);
      }
    }
  });
  EXPECT_GT(missing_in_all, 1000);
}

// Cut through, one half stretched and let go but for its end: it comes to rest as a whole where its
// end is, and the other half has not felt a thing.
TEST(CutRelaxation, OnlyItsOwnSideMoves) {
  const Size3 size{34, 6, 6};  // the cut near a brick border, the moving half across it
  std::vector<glm::ivec3> u;
  for_each_voxel(size, [&](VoxelIndex v) {
    u.emplace_back(v.x < 26 ? 0 : (v.x - 24) * 150, v.x < 26 ? 0 : (v.x - 26) * 40, 0);
  });
  const Lattice start = lattice_of(size, u);
  const Cuts cuts = with_disc(Cuts(size), Lattice(size), {25.5, 2, 2}, {1, 0, 0}, 20.0);
  const MaterialField field(
      random_volume(size, 2, 2, 4, {1, 0.8, 1.5}),
      table({material(0, 1, 0.5, 1.5, 0.24, 1.0), material(1, 2, 0.5, 1.5, 0.24, 30.0)}));
  ElementSet held;
  for_each_voxel(size, [&](VoxelIndex v) {
    if (v.x == size.x - 1) held.insert(v, start.grid());
  });
  WorkerPool pool(1);
  RelaxationOptions options;
  options.tolerance_voxels = 1e-3;
  Relaxation relaxation(start, field, cuts, held, kFree, pool, options);
  EXPECT_TRUE(run(relaxation, 1000).converged);
  EXPECT_FALSE(relaxation.progress().energy_ever_rose);
  EXPECT_LT(relaxation.progress().energy_last, 1e-4 * relaxation.progress().energy_first);
  const Lattice lattice = relaxation.lattice();
  const glm::dvec3 end = start.displacement_voxels({size.x - 1, 0, 0});
  for_each_voxel(size, [&](VoxelIndex v) {
    if (v.x < 26) {
      ASSERT_EQ(lattice.u(v), glm::ivec3(0));
    } else {
      ASSERT_LT(glm::length(lattice.displacement_voxels(v) - end), 0.01);
    }
  });
}

class CutRelaxationReference : public ::testing::TestWithParam<int> {};

TEST_P(CutRelaxationReference, EndsAtNewtonsEquilibrium) {
  const int seed = GetParam();
  SCOPED_TRACE("seed " + std::to_string(seed));
  const bool across = seed % 3 == 0;  // a brick border
  const Size3 size = across ? Size3(35, 6, 7) : Size3(9, 8, 9);
  const VoxelIndex handle_at = across ? VoxelIndex(31, 3, 3) : VoxelIndex(4, 4, 4);
  const glm::dvec3 spacing_mm{1.0, 0.8, 1.5};
  const std::vector<double> stiffness{1.0, seed % 2 ? 10.0 : 100.0, 0.3};
  const Volume volume = random_volume(size, 3, 2, static_cast<unsigned>(seed), spacing_mm);
  const std::vector<Material> materials{material(0, 1, 0.5, 1.6, 0.24, stiffness[0]),
                                        material(1, 2, 0.5, 1.6, 0.24, stiffness[1]),
                                        material(2, 3, 0.5, 1.6, 0.24, stiffness[2])};
  Deformer deformer(volume, table(materials), {});
  ASSERT_TRUE(deformer.begin_stroke(handle_at, 1).ok());
  ASSERT_TRUE(deformer.drag_to({0.7, -0.3, 0.4}, testing::workers()).ok());
  deformer.end_stroke();
  const Lattice& start = deformer.lattice();
  const ElementSet handle = ball_of_elements(handle_at, 1, start.grid());
  std::mt19937 random(static_cast<unsigned>(seed));
  std::uniform_real_distribution<double> number(-1, 1);
  const glm::dvec3 beside = glm::dvec3(handle_at) + glm::dvec3(1.6, 0.3, 0.2);
  Cuts cuts = with_disc(Cuts(size), start, beside,
                        {1 + number(random), number(random), number(random)}, 2.6);
  cuts = carve(cuts, start, glm::dvec3(handle_at) - glm::dvec3(2, 0.5, 1), 1.1);
  ASSERT_FALSE(cuts.empty());

  RelaxationOptions options;
  options.tolerance_voxels = 0.001;
  WorkerPool pool(1);
  Relaxation relaxation(start, deformer.materials(), cuts, handle, {}, pool, options);
  EXPECT_TRUE(run(relaxation, 1000).converged);
  EXPECT_FALSE(relaxation.progress().energy_ever_rose);
  const SpringProblem problem =
      testing::relaxation_twin(volume, materials, start, cuts, handle, {});
  const DenseSprings springs(problem, pool);
  const Equilibrium expected = spring_equilibrium(problem, pool);
  EXPECT_TRUE(expected.converged);
  SpringProblem whole = problem;
  whole.removed.clear();
  const Equilibrium uncut = spring_equilibrium(whole, pool);
  EXPECT_TRUE(uncut.converged);
  const Lattice lattice = relaxation.lattice();
  double worst = 0.0;
  double difference = 0.0;
  for_each_voxel(size, [&](VoxelIndex v) {
    const std::size_t i = element_of(v, size);
    const glm::dvec3 there = expected.u_voxels[i];
    worst = std::max(worst, glm::length(lattice.displacement_voxels(v) - there));
    difference = std::max(difference, glm::length(there - uncut.u_voxels[i]));
    if (problem.held[i] || springs.held(i)) {
      EXPECT_EQ(lattice.u(v), start.u(v));
    }
  });
  EXPECT_LT(worst, 0.005);      // tolerance, and rounding to 1/512 voxel
  EXPECT_GT(difference, 0.05);  // the cut does matter here
}

INSTANTIATE_TEST_SUITE_P(Seeds, CutRelaxationReference, ::testing::Range(1, 7));

TEST(CutRelaxation, SameBitsForAnyNumberOfThreads) {
  const Size3 size{80, 70, 66};
  Deformer deformer(random_volume(size, 2, 5, 3),
                    table({material(0, 1, 0.4, 2, 0.3, 1), material(1, 2, 0.9, 1.1, 0.05, 50)}),
                    {});
  ASSERT_TRUE(deformer.begin_stroke({40, 35, 33}, 3).ok());
  ASSERT_TRUE(deformer.drag_to({0, -9, 4}, testing::workers()).ok());
  const Lattice start = deformer.lattice();
  Cuts cuts = with_disc(Cuts(size), start, {36, 30, 33}, {3, 1, 1}, 25.0);
  cuts = carve(cuts, start, {50, 33, 31}, 6.0);
  std::optional<Lattice> first;
  std::optional<double> energy;
  for (const int threads : {1, 2, 3, 8}) {
    WorkerPool pool(threads);
    Relaxation relaxation(start, deformer.materials(), cuts, {}, {}, pool, {});
    run(relaxation, 20);
    const Lattice lattice = relaxation.lattice();
    if (!first) {
      first = lattice;
      energy = relaxation.progress().energy_last;
    }
    EXPECT_TRUE(equal(lattice, *first)) << threads << " threads";
    EXPECT_EQ(relaxation.progress().energy_last, *energy);
  }
}

// Nothing pulls at an element whose neighbours are all carved, nor at these.
TEST(CutRelaxation, AnElementAloneStays) {
  const Size3 size{12, 12, 12};
  std::vector<glm::ivec3> u(static_cast<std::size_t>(voxel_count(size)), glm::ivec3(0));
  const VoxelIndex alone{6, 6, 6};
  u[static_cast<std::size_t>(linear_index(alone, size))] = {300, -200, 5000};
  u[static_cast<std::size_t>(linear_index({7, 6, 6}, size))] = {-80, 20, 30};  // will be carved
  const Lattice start = lattice_of(size, u);
  Cuts cuts = carve(Cuts(size), Lattice(size), glm::dvec3(alone), 1.9);
  cuts = restore(cuts, Lattice(size), glm::dvec3(alone), 0.0);
  EXPECT_FALSE(cuts.carved(alone));
  const MaterialField field(testing::constant_volume(size),
                            table({material(0, 1, 0.5, 1.5, 0.24)}));
  WorkerPool pool(1);
  Relaxation relaxation(start, field, cuts, {}, kFree, pool, {});
  const auto progress = run(relaxation, 1000);
  EXPECT_TRUE(progress.finished());
  EXPECT_EQ(progress.energy_first, 0.0);
  EXPECT_TRUE(equal(relaxation.lattice(), start));
}

}  // namespace
}  // namespace maille
