// Material that keeps a part of its deformation: against closed forms, against Newton's method, and
// what it promises about waiting, undo and folding.
#include <cmath>

#include <gtest/gtest.h>

#include "deform/cutting.h"
#include "deform/disturbance.h"
#include "deform/yield_flow.h"
#include "references/dense_problem.h"
#include "tests/deform/relaxing.h"

namespace maille {
namespace {

using testing::constant_volume;
using testing::displacements_of;
using testing::distance_of;
using testing::equal;
using testing::for_each_voxel;
using testing::material;
using testing::RelaxationScene;
using testing::run;
using testing::springy;
using testing::table;
using testing::workers;

constexpr double kUnit = 1.0 / kUnitsPerVoxel;

RelaxationOptions within(double tolerance_voxels) {
  RelaxationOptions options;
  options.tolerance_voxels = tolerance_voxels;
  return options;
}

Material clay(double value, double yield_strain, double stiffness = 1.0, double blend = 0.25) {
  Material m = springy(value, stiffness, blend);
  m.yield_strain = yield_strain;
  return m;
}

// Values by z: 0 below, 1 from `from` on, 0 again from `to` on.
Volume two_along_z(Size3 size, int from, int to) {
  std::vector<std::uint8_t> samples;
  for_each_voxel(size, [&](VoxelIndex v) { samples.push_back(v.z >= from && v.z < to); });
  return Volume::of(size, VoxelType::uint8, axis_aligned({1, 1, 1}), std::move(samples));
}

void run_to_the_end(Relaxation& relaxation) {
  run(relaxation, 2000);
  EXPECT_TRUE(relaxation.progress().finished());
}

// A chain of elements along z, stretched by a share of its length, whose upper end lets go.
class Chain {
 public:
  static constexpr int kElements = 41;

  Chain(double stretch, glm::ivec2 second, std::vector<Material> materials)
      : scene_(two_along_z({1, 1, kElements}, second.x, second.y), std::move(materials)) {
    scene_.displace([&](VoxelIndex v) { return glm::dvec3(0, 0, stretch * v.z); });
    scene_.hold([](VoxelIndex v) { return v.z == 0; });
    scene_.released.insert({0, 0, kElements - 1}, scene_.start.grid());
    Relaxation relaxation = scene_.relaxation(workers(), within(1e-4));
    run_to_the_end(relaxation);
    kept_ = *relaxation.kept_by_flow();
    end_ = relaxation.lattice();
  }
  // By how much of their length springs have grown for good, from element z on.
  double kept(int z) const {
    return kept_.displacement_voxels({0, 0, z + 1}).z - kept_.displacement_voxels({0, 0, z}).z;
  }
  double end(int z) const { return end_.displacement_voxels({0, 0, z}).z; }

 private:
  RelaxationScene scene_;
  Lattice kept_;
  Lattice end_;
};

// Stretched by a fifth, springing back by a twentieth, again and whatever the direction.
TEST(Yield, AChainKeepsWhatGoesBeyond) {
  for (const double stretch : {0.2, -0.2}) {
    for (const double blend : {0.0, 0.25, 1.0}) {
      const Chain chain(stretch, {0, Chain::kElements},
                        {clay(0, 0.05, 1, blend), clay(1, 0.05, 1, blend)});
      const double kept = stretch > 0.0 ? 0.15 : -0.15;
      for (int z = 0; z < Chain::kElements - 1; ++z) {
        EXPECT_NEAR(chain.kept(z), kept, 1.5 * kUnit) << z;
        EXPECT_NEAR(chain.end(z), kept * z, 0.01) << z;
      }
    }
  }
}

// Rubber below, clay above: rubber is as it was, clay as far as if it had been alone.
TEST(Yield, RubberBesideClayKeepsNothing) {
  const int from = 20;
  const Chain chain(0.2, {from, Chain::kElements}, {springy(0, 1), clay(1, 0.05)});
  for (int z = 0; z <= from; ++z) EXPECT_NEAR(chain.end(z), 0.0, 0.02) << z;
  for (int z = from; z < Chain::kElements; ++z) {
    EXPECT_NEAR(chain.end(z), 0.15 * (z - from), 0.02) << z;
  }
}

// Rubber, clay, rubber: the rubber beyond is carried along by the clay between.
TEST(Yield, ClayBetweenRubberCarriesItAlong) {
  const Chain chain(0.2, {12, 25}, {springy(0, 1), clay(1, 0.05)});
  const double longer = 0.15 * 12;
  for (int z = 0; z < Chain::kElements; ++z) {
    EXPECT_NEAR(chain.end(z), std::clamp(0.15 * (z - 12), 0.0, longer), 0.02) << z;
    if (z < Chain::kElements - 1 && (z < 12 || z >= 24)) {
      EXPECT_EQ(chain.kept(z), 0.0) << z;
    }
  }
}

// Bone below, clay, and much more rubber above: of the two that do not yield bone stays.
TEST(Yield, WhatIsFixedStays) {
  Material bone = springy(0, 1);
  bone.fixed = true;
  std::vector<std::uint8_t> samples;
  for (int z = 0; z < 41; ++z) samples.push_back(z < 5 ? 0 : z < 16 ? 1 : 2);
  RelaxationScene scene(
      Volume::of({1, 1, 41}, VoxelType::uint8, axis_aligned({1, 1, 1}), std::move(samples)),
      {bone, clay(1, 0.05), springy(2, 1)});
  scene.displace([](VoxelIndex v) { return glm::dvec3(0, 0, 0.2 * std::max(0, v.z - 4)); });
  scene.released.insert({0, 0, 40}, scene.start.grid());
  Relaxation relaxation = scene.relaxation(workers(), within(1e-4));
  run_to_the_end(relaxation);
  const Lattice& kept = *relaxation.kept_by_flow();
  EXPECT_EQ(kept.u({0, 0, 0}), glm::ivec3(0));
  EXPECT_EQ(kept.u({0, 0, 5}), glm::ivec3(0));  // the spring between bone and clay never yields
  EXPECT_NEAR(kept.displacement_voxels({0, 0, 15}).z, 0.15 * 10, 4 * kUnit);
  EXPECT_EQ(kept.u({0, 0, 40}), kept.u({0, 0, 17}));
  EXPECT_NEAR(relaxation.lattice().displacement_voxels({0, 0, 40}).z, 0.15 * 10, 0.01);
}

// Two clays: each by its own yield strain, the spring between them by neither's less.
TEST(Yield, ClaysOfTwoKindsKeepTheirOwnShares) {
  const int from = 20;
  const Chain chain(0.2, {from, Chain::kElements}, {clay(0, 0.05), clay(1, 0.15)});
  for (int z = 0; z < Chain::kElements - 1; ++z) {
    const double kept = z < from - 1 ? 0.15 : z == from - 1 ? 0.1 : 0.05;
    EXPECT_NEAR(chain.kept(z), kept, 1.5 * kUnit) << z;
  }
}

// A block of one strain all over, its border held, in which one element lets go.
class StrainedBlock {
 public:
  StrainedBlock(const glm::dmat3& gradient, Material of, glm::dvec3 spacing_mm = glm::dvec3(1))
      : scene_(constant_volume({9, 13, 8}, 0, spacing_mm), {std::move(of)}) {
    scene_.anchors = {};
    scene_.displace([&](VoxelIndex v) { return gradient * glm::dvec3(v); });
    scene_.released.insert({4, 5, 3}, scene_.start.grid());
  }
  Lattice kept() {
    Relaxation relaxation = scene_.relaxation(workers(2), within(1e-3));
    run_to_the_end(relaxation);
    return *relaxation.kept_by_flow();
  }
  Size3 size() const { return scene_.size(); }

 private:
  RelaxationScene scene_;
};

// P is affine too, of the share that the spring of the largest strain says, border and all, and
// everywhere as large as that.
TEST(Yield, AnAffineBlockKeepsAnAffineShare) {
  const double y = 0.05;
  const glm::dmat3 stretched(0.2, 0, 0, 0, 0, 0, 0, 0, 0);
  const glm::dmat3 grown(0.2, 0, 0, 0, 0.2, 0, 0, 0, 0.2);
  // Of a diagonal, (1 + g, 1) over (1, 1).
  const double g = 0.25;
  const glm::dmat3 sheared(0, 0, 0, g, 0, 0, 0, 0, 0);
  const double of_sheared = std::hypot(1.0 + g, 1.0) / std::sqrt(2.0) - 1.0;
  struct Case {
    glm::dmat3 gradient;
    double strain;
    glm::dvec3 spacing_mm;
  };
  for (const Case& c :
       {Case{stretched, 0.2, glm::dvec3(1)}, Case{grown, 0.2, glm::dvec3(1)},
        Case{stretched, 0.2, {1, 0.5, 2}}, Case{sheared, of_sheared, glm::dvec3(1)}}) {
    StrainedBlock block(c.gradient, clay(0, y, 3.0, 0.5), c.spacing_mm);
    const Lattice kept = block.kept();
    const glm::dmat3 expected = (1.0 - y / c.strain) * c.gradient;
    const glm::dvec3 origin = kept.displacement_voxels({0, 0, 0});
    double worst = 0.0;
    for_each_voxel(block.size(), [&](VoxelIndex v) {
      const glm::dvec3 off = kept.displacement_voxels(v) - origin - expected * glm::dvec3(v);
      worst = std::max(worst, glm::length(off));
    });
    // Strains of positions to the nearest unit, thus shares, are off by a few in a hundred.
    EXPECT_LT(worst, 0.03);
  }
}

TEST(Yield, BelowItKeepsNothingAtAll) {
  StrainedBlock block(glm::dmat3(0.04, 0, 0, 0, -0.02, 0, 0, 0, 0), clay(0, 0.05));
  EXPECT_TRUE(block.kept().at_rest());
}

// By asin(5/13), a strain of 5/13 in many of the terms that are not a change of length.
TEST(Yield, ATurnKeepsNothing) {
  const glm::dmat3 turned(12.0 / 13 - 1, 5.0 / 13, 0, -5.0 / 13, 12.0 / 13 - 1, 0, 0, 0, 0);
  StrainedBlock block(turned, clay(0, 0.01, 1.0, 0.0));
  EXPECT_TRUE(block.kept().at_rest());
}

// --- the equilibrium of what has been kept

struct Kept {
  const char* what;
  double squeeze;  // of P along x, per voxel, in a part of the block
  bool cut;
};

class YieldReference : public ::testing::TestWithParam<Kept> {};

TEST_P(YieldReference, EndsAtNewtonsEquilibrium) {
  const Kept& p = GetParam();
  const Size3 size{9, 8, 7};
  RelaxationScene scene(testing::random_volume(size, 3, 2, 5, {1, 0.8, 1.5}),
                        {springy(0, 1, 0.15), springy(1, 10, 0.25), springy(2, 0.3, 0.5)});
  scene.anchors = {face_low_z | face_high_z, false};  // and P wants the upper one elsewhere
  std::mt19937 random(11);
  std::uniform_real_distribution<double> off(-0.1, 0.1);
  scene.keep([&](VoxelIndex v) {
    if (v.z < 2) return glm::dvec3(0);
    return glm::dvec3(p.squeeze * std::clamp(v.x - 3, 0, 3), 0, 0.15 * v.z) +
           glm::dvec3(off(random), off(random), off(random));
  });
  if (p.cut) {
    const auto disc = CutSurface::disc({4.3, 3.6, 3.3}, {1, 2, -1}, 2.5, glm::dvec3(1));
    scene.cuts = *cut_along(scene.cuts, Lattice(size), *disc);
  }
  Relaxation relaxation = scene.relaxation(workers(2), within(1e-4));
  run_to_the_end(relaxation);
  EXPECT_TRUE(relaxation.progress().converged);
  const SpringProblem twin = scene.twin();
  const Equilibrium expected = spring_equilibrium(twin, workers());
  ASSERT_TRUE(expected.converged);
  ASSERT_TRUE(expected.stable);
  EXPECT_LT(distance_of(relaxation.displacements_voxels(), expected.u_voxels, twin.held).largest,
            1e-3);
  // It has gone somewhere, and where it should near cells close to folding.
  const DisplacementField nothing(expected.u_voxels.size(), glm::dvec3(0));
  EXPECT_GT(distance_of(expected.u_voxels, nothing, twin.held).largest, 0.5);
  const DenseSprings springs(twin, workers());
  const double least = springs.least_determinant(mm_of(expected.u_voxels, twin.spacing_mm));
  EXPECT_EQ(least < 0.3, p.squeeze < -0.5) << least;
}

INSTANTIATE_TEST_SUITE_P(Scenes, YieldReference,
                         ::testing::Values(Kept{"gentle", -0.2, false}, Kept{"cut", -0.2, true},
                                           Kept{"pressed_flat", -0.75, false}),
                         [](const auto& param) { return std::string(param.param.what); });

// --- with handles

MaterialTable clay_table(double yield_strain) {
  Material m = material(0, 1, 0.4, 2.0, 0.6);
  m.yield_strain = yield_strain;
  return table({m});
}

// A block of clay with its faces held, pulled in its middle.
class Pulled {
 public:
  explicit Pulled(double yield_strain = 0.05, int threads = 1)
      : pool_(workers(threads)),
        deformer_(constant_volume({15, 14, 13}), clay_table(yield_strain), {63, false}) {
    begin();
  }
  void begin() {
    ASSERT_TRUE(deformer_.begin_stroke({7, 7, 6}, 1.5, "middle").ok());
    ASSERT_TRUE(deformer_.drag_to({2.5, 0.5, -0.25}, pool_).ok());
    deformer_.end_stroke();
  }
  void relax(int most_iterations = 2000) {
    Relaxation relaxation = deformer_.relax(pool_, within(kTolerance));
    run(relaxation, most_iterations);
    std::optional<double> finished;
    if (relaxation.progress().finished()) finished = kTolerance;
    deformer_.adopt(relaxation.lattice(), finished, relaxation.kept_by_flow());
  }
  void release() { ASSERT_TRUE(deformer_.release("middle").ok()); }

  static constexpr double kTolerance = 1e-3;
  Deformer& deformer() { return deformer_; }

 private:
  WorkerPool& pool_;
  Deformer deformer_;
};

double furthest(const Lattice& a, const Lattice& b) {
  return distance_of(displacements_of(a), displacements_of(b),
                     std::vector<std::uint8_t>(displacements_of(a).size(), 0))
      .largest;
}

TEST(Yield, ClayStaysAndRubberDoesNot) {
  Pulled clay_block;
  clay_block.relax();
  EXPECT_TRUE(clay_block.deformer().kept().at_rest());  // nothing flows while the handle holds
  clay_block.release();
  clay_block.relax();
  const double stays = clay_block.deformer().lattice().displacement_voxels({7, 7, 6}).x;
  EXPECT_GT(stays, 1.5);
  EXPECT_LT(stays, 2.45);
  // The handle's inside, strained by nothing, has gone along.
  const Lattice& of_clay = clay_block.deformer().kept();
  EXPECT_LT(
      glm::length(of_clay.displacement_voxels({7, 7, 6}) - of_clay.displacement_voxels({7, 7, 7})),
      0.02);
  EXPECT_EQ(of_clay.u({0, 0, 0}), glm::ivec3(0));
  // Nothing is left to flow: relaxing on changes nothing.
  const Lattice kept = clay_block.deformer().kept();
  clay_block.relax();
  EXPECT_TRUE(equal(clay_block.deformer().kept(), kept));

  Pulled rubber_block(1e3);
  rubber_block.relax();
  rubber_block.release();
  rubber_block.relax();
  EXPECT_TRUE(rubber_block.deformer().kept().at_rest());
  EXPECT_LT(furthest(rubber_block.deformer().lattice(), Lattice({15, 14, 13})), 0.01);
}

// However far the springs have come when the handle is released.
TEST(Yield, WaitingChangesNothing) {
  Pulled patient;
  patient.relax();
  patient.release();
  patient.relax();
  for (const int iterations : {0, 2, 5}) {
    Pulled hasty;
    if (iterations > 0) hasty.relax(iterations);
    hasty.release();
    hasty.relax();
    EXPECT_LT(furthest(hasty.deformer().kept(), patient.deformer().kept()), 0.01) << iterations;
    EXPECT_LT(furthest(hasty.deformer().lattice(), patient.deformer().lattice()), 0.01)
        << iterations;
  }
}

// A release that is interrupted before it has flown goes on where it was.
TEST(Yield, GoesOnAfterAnInterruption) {
  Pulled whole;
  whole.release();
  whole.relax();
  Pulled parts;
  parts.release();
  for (int i = 0; i < 3; ++i) parts.relax(1);
  parts.relax();
  EXPECT_LT(furthest(parts.deformer().kept(), whole.deformer().kept()), 0.01);
  EXPECT_LT(furthest(parts.deformer().lattice(), whole.deformer().lattice()), 0.01);
}

TEST(Yield, MindsNoThreads) {
  std::vector<Lattice> kept;
  std::vector<Lattice> end;
  for (const int threads : {1, 2, 5}) {
    Pulled block(0.05, threads);
    block.relax(4);
    block.release();
    block.relax();
    kept.push_back(block.deformer().kept());
    end.push_back(block.deformer().lattice());
    EXPECT_TRUE(equal(kept.back(), kept.front())) << threads;
    EXPECT_TRUE(equal(end.back(), end.front())) << threads;
  }
  EXPECT_FALSE(kept.front().at_rest());
}

TEST(Yield, UndoBringsBackWhatWasKept) {
  Pulled block;
  Deformer& deformer = block.deformer();
  block.relax();
  struct State {
    Lattice lattice;
    Lattice kept;
    std::size_t handles;
  };
  const auto now = [&] {
    return State{deformer.lattice(), deformer.kept(), deformer.handle_names().size()};
  };
  const auto expect = [&](const State& state) {
    EXPECT_TRUE(equal(deformer.lattice(), state.lattice));
    EXPECT_TRUE(equal(deformer.kept(), state.kept));
    EXPECT_EQ(deformer.handle_names().size(), state.handles);
  };
  std::vector<State> states{now()};
  block.release();
  block.relax();
  states.push_back(now());
  block.begin();
  block.relax();
  states.push_back(now());
  block.release();
  block.relax();
  states.push_back(now());
  EXPECT_GT(furthest(states[3].kept, states[1].kept), 0.1);
  for (int around = 0; around < 2; ++around) {
    for (int i = 2; i >= 0; --i) {
      ASSERT_TRUE(deformer.undo());
      expect(states[static_cast<std::size_t>(i)]);
    }
    for (int i = 1; i <= 3; ++i) {
      ASSERT_TRUE(deformer.redo());
      expect(states[static_cast<std::size_t>(i)]);
    }
  }
  // What was released has flown once, on the way there and back.
  block.relax();
  EXPECT_TRUE(equal(deformer.kept(), states[3].kept));
  // And one that is undone may be released otherwise.
  ASSERT_TRUE(deformer.undo());
  block.release();
  block.relax();
  EXPECT_LT(furthest(deformer.kept(), states[3].kept), 0.01);
}

// What undo holds of it is counted, and freed with the step.
TEST(Yield, WhatUndoKeepsIsCounted) {
  Pulled block;
  block.relax();
  block.release();
  block.relax();
  const History& history = *block.deformer().history();
  ASSERT_TRUE(block.deformer().undo());  // the redo step holds P
  const Lattice rest(block.deformer().kept().grid().volume_size());
  EXPECT_TRUE(equal(block.deformer().kept(), rest));
  const std::int64_t planes = 3 * kBrickVoxels * 2;
  EXPECT_GT(history.bytes(), 2 * planes);  // u and P of the one brick
}

// Cuts leave what is kept alone.
TEST(Yield, CuttingAndCarvingLeaveIt) {
  Pulled block;
  block.release();
  block.relax();
  const Lattice kept = block.deformer().kept();
  ASSERT_TRUE(block.deformer().carve({7, 7, 6}, 2).ok());
  EXPECT_TRUE(equal(block.deformer().kept(), kept));
  block.relax();
  ASSERT_TRUE(block.deformer().restore({7, 7, 6}, 2).ok());
  block.relax();
  EXPECT_TRUE(equal(block.deformer().kept(), kept));
}

// Layers pressed flat would all but stay so, to J = 0.03: fewer of it is kept there, and all of it
// that presses nothing flat.
TEST(Yield, TheStateOfRestIsNotFolded) {
  const Size3 size{14, 7, 6};
  for (const double pressed : {0.97, 0.8}) {
    RelaxationScene scene(constant_volume(size, 0, {1, 0.8, 1.5}), {clay(0, 1e-3)});
    scene.displace(
        [&](VoxelIndex v) { return glm::dvec3(-pressed * std::clamp(v.x - 5, 0, 3), 0, 0); });
    SpringProblem twin = scene.twin();
    const DenseSprings springs(twin, workers());
    const auto least = [&](const Lattice& lattice) {
      return springs.least_determinant(mm_of(displacements_of(lattice), twin.spacing_mm));
    };
    ASSERT_NEAR(least(scene.start), 1.0 - pressed, 0.01);
    const YieldFlow flow = let_yield(
        {scene.start, scene.kept, scene.field, scene.cuts, std::int64_t{1} << 30}, workers());
    EXPECT_GT(least(flow.kept), 0.05);
    const double ends =
        flow.kept.displacement_voxels({0, 3, 3}).x - flow.kept.displacement_voxels({13, 3, 3}).x;
    if (pressed == 0.8) {
      EXPECT_NEAR(ends, 3 * pressed, 0.02);
    } else {
      EXPECT_GT(ends, 1.0);
    }
  }
}

// Where memory is short, what is furthest out does not flow, and the relaxation says so.
TEST(Yield, FlowsWhereMemoryAllows) {
  Pulled block;
  block.relax();
  block.release();
  RelaxationOptions options = within(0.01);
  options.memory_bytes = 128 * 300;
  Relaxation relaxation = block.deformer().relax(workers(), options);
  run_to_the_end(relaxation);
  EXPECT_TRUE(relaxation.progress().region_limited);
  ASSERT_NE(relaxation.kept_by_flow(), nullptr);
  EXPECT_FALSE(relaxation.kept_by_flow()->at_rest());
  EXPECT_LE(voxel_count(moved_box(*relaxation.kept_by_flow()).size()), 300);
}

}  // namespace
}  // namespace maille
