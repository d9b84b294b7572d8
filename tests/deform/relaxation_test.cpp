// Relaxation against closed forms and against Newton's method in double precision.
#include "deform/relaxation.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/failure.h"
#include "deform/spring_box.h"
#include "references/dense_problem.h"
#include "tests/deform/relaxing.h"

namespace maille {
namespace {

using testing::constant_volume;
using testing::displacements_of;
using testing::distance_of;
using testing::equal;
using testing::for_each_voxel;
using testing::kFree;
using testing::material;
using testing::random_volume;
using testing::RelaxationScene;
using testing::run;
using testing::springy;
using testing::table;
using testing::workers;

constexpr double kUnit = 1.0 / kUnitsPerVoxel;
// What a lattice may be off by where displacements_voxels() is exact, in all three components.
constexpr double kRounding = 0.87 * kUnit;

RelaxationOptions within(double tolerance_voxels) {
  RelaxationOptions options;
  options.tolerance_voxels = tolerance_voxels;
  return options;
}

void expect_well_ended(const Relaxation& relaxation) {
  EXPECT_TRUE(relaxation.progress().finished());
  EXPECT_FALSE(relaxation.progress().energy_ever_rose);
  EXPECT_LE(relaxation.progress().energy_last, relaxation.progress().energy_first);
}

// --- closed forms

// Two springs in series, of different stiffness, one end held and the other pulled by D: the middle
// settles at D k2 / (k1 + k2), where a spring between materials is two halves in series.
TEST(Relaxation, SpringPair) {
  const Size3 size{3, 1, 1};
  const double k1 = 2.0;
  const double k2 = 2.0 / (1.0 / 2.0 + 1.0 / 6.0);
  const double pull = 3.0;
  for (const double blend : {0.0, 0.25, 1.0}) {
    std::vector<std::uint8_t> samples{0, 0, 1};
    RelaxationScene scene(
        Volume::of(size, VoxelType::uint8, axis_aligned({0.7, 1, 1}), std::move(samples)),
        {springy(0, 2.0, blend), springy(1, 6.0, blend)});
    scene.displace([&](VoxelIndex v) { return glm::dvec3(v.x == 2 ? pull : 0.0, 0, 0); });
    scene.hold([](VoxelIndex v) { return v.x != 1; });
    Relaxation relaxation = scene.relaxation(workers(), within(1e-6));
    run(relaxation, 100);
    expect_well_ended(relaxation);
    EXPECT_NEAR(relaxation.displacements_voxels()[1].x, pull * k2 / (k1 + k2), 2e-6) << blend;
    // Of two springs that are both pulled on: half the pull's square over their compliances.
    const double pull_mm = 0.7 * pull;
    EXPECT_NEAR(relaxation.progress().energy_last, 0.5 * pull_mm * pull_mm / (1.0 / k1 + 1.0 / k2),
                1e-5);
  }
}

// A chain held at one end and pulled at the other: each spring takes its share of the pull in
// proportion to its compliance.
TEST(Relaxation, ChainUnderAPinnedDisplacement) {
  const int n = 45;  // crosses a brick border
  const Size3 size{1, 1, n};
  const std::vector<double> stiffness{1.0, 4.0, 20.0};
  RelaxationScene scene(random_volume(size, 3, 1, 11, {1, 1, 0.8}),
                        {springy(0, 1.0), springy(1, 4.0), springy(2, 20.0)});
  const auto compliance = [&](int z) {
    return 1.0 / stiffness[static_cast<std::size_t>(scene.volume.value_at({0, 0, z}))];
  };
  const double pull = 6.0;
  scene.displace([&](VoxelIndex v) { return glm::dvec3(0, 0, v.z == n - 1 ? pull : 0.0); });
  scene.hold([](VoxelIndex v) { return v.z == 0 || v.z == n - 1; });
  Relaxation relaxation = scene.relaxation(workers(2), within(1e-4));
  run(relaxation, 1000);
  expect_well_ended(relaxation);
  double total = 0.0;
  for (int z = 1; z < n; ++z) total += 0.5 * (compliance(z) + compliance(z - 1));
  const auto u = relaxation.displacements_voxels();
  double share = 0.0;
  for (int z = 1; z < n; ++z) {
    share += 0.5 * (compliance(z) + compliance(z - 1));
    EXPECT_NEAR(u[static_cast<std::size_t>(z)].z, pull * share / total, 2e-4) << z;
  }
}

// Two by two elements wide, every element of a bar is alike, so that it narrows evenly. Narrowed to
// mu it has no force across where it is stretched by the lambda at which these cancel: the springs
// across, to the one element opposite, and the two diagonals ahead and behind.
TEST(Relaxation, BarInUniaxialStretch) {
  const Size3 size{29, 2, 2};
  const double mu = 1.0 - 32 * kUnit;
  for (const double blend : {0.0, 0.25, 0.6}) {
    const auto force_across = [&](double lambda) {
      const double ahead = std::hypot(lambda, mu);
      const double by_length = 2.0 * (mu - 1.0) + 2.0 * (ahead - std::sqrt(2.0)) / ahead * mu;
      return (1.0 - blend) * by_length + blend * 4.0 * (mu - 1.0);
    };
    double low = 1.0;
    double high = 3.0;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (force_across(middle) < 0.0 ? low : high) = middle;
    }
    const double lambda = low;
    RelaxationScene scene(constant_volume(size), {springy(0, 3.0, blend)});
    scene.displace([&](VoxelIndex v) {
      const bool end = v.x == 0 || v.x == size.x - 1;
      return end ? glm::dvec3((lambda - 1.0) * v.x, (mu - 1.0) * v.y, (mu - 1.0) * v.z)
                 : glm::dvec3(0);
    });
    scene.hold([&](VoxelIndex v) { return v.x == 0 || v.x == size.x - 1; });
    Relaxation relaxation = scene.relaxation(workers(), within(1e-5));
    run(relaxation, 1000);
    expect_well_ended(relaxation);
    const auto u = relaxation.displacements_voxels();
    for (int x = 10; x < 19; ++x) {
      const glm::dvec3 low_side = u[element_of({x, 0, 0}, size)];
      const glm::dvec3 high_side = u[element_of({x, 1, 1}, size)];
      EXPECT_NEAR(high_side.y - low_side.y, mu - 1.0, 1e-4) << blend;
      EXPECT_NEAR(high_side.z - low_side.z, mu - 1.0, 1e-4) << blend;
      // The far end lies on the nearest unit only.
      EXPECT_NEAR(low_side.x, (lambda - 1.0) * x, 0.5 * kUnit + 1e-4) << blend;
    }
  }
}

// In an affine deformation of one material every spring has its opposite, so wherever the border
// holds one the inside follows, whatever it did before, any spacing and any blend.
TEST(Relaxation, StretchedAndShearedBlocksAreAffine) {
  const Size3 size{9, 17, 9};
  const glm::dmat3 stretched(1.0 / 8, 0, 0, 0, -1.0 / 16, 0, 0, 0, -1.0 / 32);
  const glm::dmat3 sheared(0, 0, 0, 1.0 / 4, 0, 0, 1.0 / 16, 0, 0);
  for (const glm::dmat3& gradient : {stretched, sheared}) {
    for (const glm::dvec3 spacing_mm : {glm::dvec3(1), glm::dvec3(1, 2, 0.5)}) {
      for (const double blend : {0.0, 0.25, 1.0}) {
        // Lengths alone buckle here: the energy has lesser minima than the affine one nearby.
        if (blend == 0.0 && spacing_mm != glm::dvec3(1)) continue;
        RelaxationScene scene(constant_volume(size, 0, spacing_mm), {springy(0, 0.3, blend)});
        scene.anchors = {};
        std::mt19937 random(3);
        std::uniform_real_distribution<double> off(-0.05, 0.05);
        scene.displace([&](VoxelIndex v) {
          const glm::dvec3 noise(off(random), off(random), off(random));
          return gradient * glm::dvec3(v) + (faces_of(v, size) ? glm::dvec3(0) : noise);
        });
        Relaxation relaxation = scene.relaxation(workers(2), within(1e-5));
        run(relaxation, 1000);
        expect_well_ended(relaxation);
        const auto u = relaxation.displacements_voxels();
        double worst = 0.0;
        for_each_voxel(size, [&](VoxelIndex v) {
          worst = std::max(worst, glm::length(u[element_of(v, size)] - gradient * glm::dvec3(v)));
        });
        EXPECT_LT(worst, 1e-4) << blend << ", spacing " << spacing_mm.y;
      }
    }
  }
}

// The turn by asin(5/13) takes multiples of 13 to whole voxels.
constexpr int kTurned = 14;
glm::dvec3 turned_by(glm::dvec3 x) {
  return {(12.0 * x.x - 5.0 * x.y) / 13.0 - x.x, (5.0 * x.x + 12.0 * x.y) / 13.0 - x.y, 0.0};
}

// Springs that mind lengths alone have nothing against being turned: dragged there by its edges
// along z, one after the other, a block ends as it was but turned, without any energy.
TEST(Relaxation, ATurnedBlockIsFoundFromChainMail) {
  const Size3 size(kTurned);
  Material without_blend = material(0, 1, 0.4, 1.6, 0.6, 2.0);
  without_blend.rest_vector_blend = 0.0;
  RelaxationScene scene(constant_volume(size), {without_blend});
  const int far = kTurned - 1;
  const auto edge = [&](glm::ivec2 at) {
    std::vector<VoxelIndex> voxels;
    for (int z = 0; z < size.z; ++z) voxels.emplace_back(at.x, at.y, z);
    return voxels;
  };
  std::vector<VoxelIndex> held = edge({0, 0});
  for (const glm::ivec2 at : {glm::ivec2(far, 0), glm::ivec2(0, far), glm::ivec2(far, far)}) {
    const glm::dvec3 by = turned_by({at, 0}) * double{kUnitsPerVoxel};
    const testing::Drag drag{scene.field, scene.start, edge(at), held};
    const ChainMailAnswer answer = drag.by(glm::ivec3(glm::round(by)) - scene.start.u({at, 0}));
    ASSERT_FALSE(answer.clamped);
    scene.start = answer.lattice;
    for (const VoxelIndex v : edge(at)) held.push_back(v);
  }
  scene.held = testing::elements(held, scene.start.grid());
  Relaxation relaxation = scene.relaxation(workers(2), within(1e-4));
  const double energy_first = relaxation.progress().energy_first;
  EXPECT_GT(energy_first, 10.0);
  run(relaxation, 1000);
  expect_well_ended(relaxation);
  EXPECT_LT(relaxation.progress().energy_last, 1e-6 * energy_first);
  const auto u = relaxation.displacements_voxels();
  double worst = 0.0;
  for_each_voxel(size, [&](VoxelIndex v) {
    worst = std::max(worst, glm::length(u[element_of(v, size)] - turned_by(glm::dvec3(v))));
  });
  EXPECT_LT(worst, 0.002) << relaxation.progress().iterations << " iterations";
}

// Springs that mind direction too hold, of a block turned as a whole, 1/2 b k |(R - 1) r|^2 each.
TEST(Relaxation, ATurnedBlockHasTheEnergyOfItsBlend) {
  const Size3 size(kTurned);
  const double k = 2.0;
  for (const double blend : {0.0, 0.125, 0.5, 1.0}) {
    RelaxationScene scene(constant_volume(size), {springy(0, k, blend)});
    scene.anchors = {};
    std::mt19937 random(3);
    std::uniform_real_distribution<double> off(-0.2, 0.2);
    scene.displace([&](VoxelIndex v) {
      const glm::dvec3 noise(off(random), off(random), off(random));
      return turned_by(glm::dvec3(v)) + (faces_of(v, size) ? glm::dvec3(0) : noise);
    });
    Relaxation relaxation = scene.relaxation(workers(2), within(1e-5));
    run(relaxation, 2000);
    expect_well_ended(relaxation);
    double expected = 0.0;
    for_each_voxel(size, [&](VoxelIndex v) {
      for (const glm::ivec3& offset : DenseSprings::kOffsets) {
        const VoxelIndex other = v + offset;
        if (!contains(size, other) || (faces_of(v, size) && faces_of(other, size))) continue;
        const glm::dvec3 turned = turned_by(glm::dvec3(offset));
        expected += 0.5 * blend * k * glm::dot(turned, turned);
      }
    });
    // What holds lies on the nearest unit: off by a third of half of one, as noise does.
    const double noise = k * 18 * static_cast<double>(voxel_count(size)) * kUnit * kUnit;
    EXPECT_NEAR(relaxation.progress().energy_last, expected, 1e-3 * expected + noise) << blend;
  }
}

// A curtain by two of its rings, drawn at the lower hem out of its plane.
TEST(Relaxation, HangingSheetIsWhereNewtonSays) {
  const Size3 size{21, 1, 17};
  for (const double blend : {0.25, 0.6}) {
    RelaxationScene scene(constant_volume(size, 0, {1, 1, 0.8}), {springy(0, 5.0, blend)});
    scene.displace([&](VoxelIndex v) {
      return v.z == 0 && v.x == 10 ? glm::dvec3(2, 1.5, -3) : glm::dvec3(0);
    });
    scene.hold([&](VoxelIndex v) {
      return v.z == size.z - 1 ? v.x == 2 || v.x == 18 : v.z == 0 && v.x == 10;
    });
    Relaxation relaxation = scene.relaxation(workers(2), within(1e-6));
    run(relaxation, 1000);
    expect_well_ended(relaxation);
    const SpringProblem twin = scene.twin();
    const Equilibrium expected = spring_equilibrium(twin, workers());
    ASSERT_TRUE(expected.converged);
    ASSERT_TRUE(expected.stable);
    EXPECT_LT(distance_of(relaxation.displacements_voxels(), expected.u_voxels, twin.held).largest,
              1e-5)
        << "blend " << blend << ", said " << relaxation.progress().residual_voxels << " after "
        << relaxation.progress().iterations;
  }
}

// --- the reference

struct Case {
  const char* what;
  std::vector<double> stiffness;  // of three materials
  glm::dvec3 spacing_mm;
};

class RelaxationReference : public ::testing::TestWithParam<std::tuple<Case, int>> {};

// From a ChainMail start to where Newton's method gets from it too.
TEST_P(RelaxationReference, EndsAtNewtonsEquilibrium) {
  const auto& [c, seed] = GetParam();
  const Size3 size{9, 8, 7};
  std::vector<Material> materials;
  for (int m = 0; m < 3; ++m) {
    materials.push_back(
        material(m, m + 1, 0.5, 1.6, 0.24, c.stiffness[static_cast<std::size_t>(m)]));
    materials.back().rest_vector_blend = 0.15 + 0.1 * m;
  }
  const Volume volume = random_volume(size, 3, 2, static_cast<unsigned>(seed), c.spacing_mm);
  Deformer deformer(volume, table(materials), {});
  ASSERT_TRUE(deformer.begin_stroke({4, 4, 3}, 1).ok());
  ASSERT_TRUE(deformer.drag_to({1.1, -0.4, 0.5}, workers()).ok());
  deformer.end_stroke();
  const ElementSet handle = ball_of_elements({4, 4, 3}, 1, deformer.lattice().grid());
  Relaxation relaxation = deformer.relax(workers(2), within(0.001));
  run(relaxation, 1000);
  expect_well_ended(relaxation);
  EXPECT_TRUE(relaxation.progress().converged);
  SpringProblem twin =
      testing::relaxation_twin(volume, materials, deformer.lattice(), Cuts(size), handle, {});
  // Where stiffness differs by millions the springs have several equilibria, and two solvers may
  // choose two; that it is one the reference sees from there.
  if (c.stiffness[1] > 1e6) twin.start_voxels = relaxation.displacements_voxels();
  const Equilibrium expected = spring_equilibrium(twin, workers());
  EXPECT_TRUE(expected.converged);
  EXPECT_TRUE(expected.stable);
  const Lattice lattice = relaxation.lattice();
  EXPECT_LT(distance_of(displacements_of(lattice), expected.u_voxels, twin.held).largest,
            0.003 + kRounding);
  for_each_voxel(size, [&](VoxelIndex v) {
    if (twin.held[element_of(v, size)]) {
      EXPECT_EQ(lattice.u(v), deformer.lattice().u(v));
    }
  });
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, RelaxationReference,
    ::testing::Combine(::testing::Values(Case{"alike", {1, 1, 1}, {1, 1, 1}},
                                         Case{"anisotropic", {1, 1, 1}, {1, 0.3, 3}},
                                         Case{"mixed", {1, 10, 0.3}, {1, 0.8, 1.5}},
                                         Case{"very mixed", {1, 1000, 30}, {1, 1, 1}},
                                         Case{"clamped", {1, 1e9, 30}, {1, 1, 1}}),
                       ::testing::Range(1, 4)),
    [](const auto& param) {
      std::string name = std::get<0>(param.param).what;
      std::replace(name.begin(), name.end(), ' ', '_');
      return name + std::to_string(std::get<1>(param.param));
    });

// What holds, by each rule: stated faces, the border where none are stated, nothing; besides, what
// is pinned and what is fixed.
TEST(Relaxation, WhatHoldsAndWhatDoesNot) {
  const Size3 size{8, 7, 9};
  std::vector<Material> materials{springy(0, 1.0), springy(1, 5.0), springy(2, 2.0)};
  materials[2].fixed = true;
  for (const bool fixed : {false, true}) {
    for (const AnchorRules anchors :
         {AnchorRules{}, AnchorRules{face_low_x, false},
          AnchorRules{face_high_y | face_low_z, true}, AnchorRules{0, true}}) {
      SCOPED_TRACE("faces " + std::to_string(anchors.faces) + (anchors.free_border ? " free" : "") +
                   (fixed ? " fixed" : ""));
      RelaxationScene scene(random_volume(size, fixed ? 3 : 2, 2, 6, {1, 1.3, 0.9}), materials);
      scene.anchors = anchors;
      std::mt19937 random(4);
      std::uniform_real_distribution<double> off(-0.15, 0.15);
      scene.displace([&](VoxelIndex v) {
        const glm::dvec3 noise(off(random), off(random), off(random));
        return noise + (v.x == 4 && v.y == 3 ? glm::dvec3(0.4, 0, 0.2) : glm::dvec3(0));
      });
      scene.hold([](VoxelIndex v) { return v.x == 4 && v.y == 3 && v.z > 2 && v.z < 6; });
      Relaxation relaxation = scene.relaxation(workers(2), within(0.001));
      run(relaxation, 1000);
      expect_well_ended(relaxation);
      const SpringProblem twin = scene.twin();
      const Equilibrium expected = spring_equilibrium(twin, workers());
      ASSERT_TRUE(expected.converged);
      EXPECT_LT(
          distance_of(relaxation.displacements_voxels(), expected.u_voxels, twin.held).largest,
          0.003);
      const Lattice lattice = relaxation.lattice();
      std::int64_t free = 0;
      for_each_voxel(size, [&](VoxelIndex v) {
        if (twin.held[element_of(v, size)]) {
          EXPECT_EQ(lattice.u(v), scene.start.u(v));
        } else {
          ++free;
        }
      });
      EXPECT_EQ(relaxation.progress().free_elements, free);
    }
  }
}

// --- the rest of its promises

TEST(Relaxation, SameBitsForAnyNumberOfThreads) {
  const Size3 size{80, 70, 66};
  const Volume volume = random_volume(size, 2, 5, 3);
  Deformer deformer(
      volume, table({material(0, 1, 0.4, 2, 0.3, 1), material(1, 2, 0.9, 1.1, 0.05, 50)}), {});
  ASSERT_TRUE(deformer.begin_stroke({40, 35, 33}, 3).ok());
  ASSERT_TRUE(deformer.drag_to({0, -9, 4}, workers()).ok());
  std::optional<Lattice> lattice;
  std::optional<DisplacementField> u;
  RelaxationProgress progress;
  for (const int threads : {1, 2, 3, 8}) {
    WorkerPool pool(threads);
    Relaxation relaxation = deformer.relax(pool, within(1e-4));
    for (int i = 0; i < 12; ++i) relaxation.iterate();
    if (!lattice) {
      lattice = relaxation.lattice();
      u = relaxation.displacements_voxels();
      progress = relaxation.progress();
    }
    EXPECT_TRUE(equal(relaxation.lattice(), *lattice)) << threads << " threads";
    EXPECT_TRUE(relaxation.displacements_voxels() == *u) << threads << " threads";
    EXPECT_EQ(relaxation.progress().energy_last, progress.energy_last);
    EXPECT_EQ(relaxation.progress().residual_voxels, progress.residual_voxels);
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
  Relaxation relaxation = deformer.relax(workers(2), within(1e-4));
  EXPECT_TRUE(run(relaxation, 1000).converged);
  EXPECT_LT(relaxation.progress().energy_last, 1e-6 * relaxation.progress().energy_first);
  deformer.adopt(relaxation.lattice());
  EXPECT_TRUE(deformer.lattice().at_rest());
  ASSERT_TRUE(deformer.undo());
}

TEST(Relaxation, NothingToDoIsConverged) {
  const Size3 size{10, 10, 10};
  Deformer deformer(constant_volume(size), table({material(0, 1, 0.5, 1.5, 0.24)}), {});
  Relaxation relaxation = deformer.relax(workers(), {});
  EXPECT_TRUE(relaxation.iterate().converged);
  EXPECT_EQ(relaxation.progress().iterations, 0);
  EXPECT_EQ(relaxation.progress().element_updates, 0);
  EXPECT_EQ(relaxation.progress().residual_voxels, 0.0);
  EXPECT_EQ(relaxation.bytes(), 0);
}

// All that has moved is held: over before it begins, and nothing has changed.
TEST(Relaxation, NoFreeElementIsConverged) {
  RelaxationScene scene(constant_volume({5, 4, 3}), {springy(0, 1.0)});
  scene.displace([](VoxelIndex v) { return glm::dvec3(0.1 * v.x * v.y, 0, 0); });
  scene.hold([](VoxelIndex) { return true; });
  Relaxation relaxation = scene.relaxation(workers());
  EXPECT_TRUE(relaxation.iterate().converged);
  EXPECT_EQ(relaxation.progress().free_elements, 0);
  EXPECT_TRUE(equal(relaxation.lattice(), scene.start));
}

// Once it is over nothing moves any more, and the time that passes costs nothing.
TEST(Relaxation, SleepsWhenOver) {
  RelaxationScene scene(constant_volume(Size3(12)), {springy(0, 1.0)});
  scene.anchors = {};
  scene.displace([](VoxelIndex v) { return glm::dvec3(v == VoxelIndex(6) ? 1.5 : 0.0, 0, 0); });
  scene.hold([](VoxelIndex v) { return v == VoxelIndex(6); });
  Relaxation relaxation = scene.relaxation(workers());
  run(relaxation, 1000);
  ASSERT_TRUE(relaxation.progress().converged);
  const auto iterations = relaxation.progress().iterations;
  const auto u = relaxation.displacements_voxels();
  relaxation.iterate();
  EXPECT_EQ(relaxation.progress().iterations, iterations);
  EXPECT_TRUE(relaxation.displacements_voxels() == u);
}

// What converged says is where a new relaxation has nothing left to do.
TEST(Relaxation, ContinuedFromItsEndItIsOverAtOnce) {
  RelaxationScene scene(random_volume(Size3(14), 2, 4, 8), {springy(0, 1.0), springy(1, 50.0)});
  scene.anchors = {};
  scene.displace([](VoxelIndex v) { return glm::dvec3(v == VoxelIndex(6) ? 1.5 : 0.0, 0, 0); });
  scene.hold([](VoxelIndex v) { return v == VoxelIndex(6); });
  Relaxation first = scene.relaxation(workers());
  run(first, 1000);
  ASSERT_TRUE(first.progress().converged);
  scene.start = first.lattice();
  Relaxation again = scene.relaxation(workers());
  EXPECT_LE(run(again, 1000).iterations, 2);
  EXPECT_TRUE(again.progress().converged);
}

// Lattices hold integers, so that no NaN comes in from there; but what lies 10^36 mm away is
// infinite in a float, and two such places are no number apart.
TEST(Relaxation, WhatIsNotFiniteIsFoundAndNamed) {
  RelaxationScene scene(constant_volume(Size3(8), 0, glm::dvec3(1e37)), {springy(0, 1.0)});
  const VoxelIndex there{3, 5, 2};
  scene.displace([&](VoxelIndex v) { return glm::dvec3(v == there ? 1000.0 : 0.0, 0, 0); });
  try {
    Relaxation relaxation = scene.relaxation(workers());
    run(relaxation, 100);
    ADD_FAILURE() << "nothing was found";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.error().kind, ErrorKind::failed);
    EXPECT_NE(failure.error().message.find("(3, 5, 2)"), std::string::npos)
        << failure.error().message;
  }
}

}  // namespace
}  // namespace maille
