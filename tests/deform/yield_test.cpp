// Material that keeps a part of its deformation: against closed forms, against Newton's method, and
// what it promises about waiting, undo and folding.
#include <Eigen/Sparse>
#include <cmath>
#include <tuple>

#include <gtest/gtest.h>

#include "deform/cutting.h"
#include "deform/disturbance.h"
#include "deform/fold_cluster.h"
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

// Newton's steps on a few elements together go to where those of the reference go.
TEST(Yield, ElementsMovedTogetherKnowWhatIsKept) {
  const Size3 size(5);
  RelaxationScene scene(testing::random_volume(size, 2, 1, 3, {1, 0.8, 1.5}),
                        {springy(0, 1, 0.4), springy(1, 5, 0.6)});
  scene.anchors = {};
  std::mt19937 random(4);
  std::uniform_real_distribution<double> off(-0.3, 0.3);
  scene.keep([&](VoxelIndex) { return glm::dvec3(off(random), off(random), off(random)); });
  SpringBox box({scene.start, scene.field, scene.cuts, scene.held, scene.anchors, &scene.kept},
                {{}, size}, workers());
  std::vector<std::int64_t> elements;
  for (std::int64_t e = 0; e < voxel_count(box.extent()); ++e) {
    if (box.is_free(e)) elements.push_back(e);
  }
  ASSERT_EQ(elements.size(), 27u);
  const FoldEnergy folds(box);
  FoldCluster cluster(folds, elements);
  for (int i = 0; i < 20; ++i) static_cast<void>(cluster.step());
  cluster.write_to(box.u_mm());
  const SpringProblem twin = scene.twin();
  const Equilibrium expected = spring_equilibrium(twin, workers());
  ASSERT_TRUE(expected.converged);
  double furthest = 0.0;
  for (const std::int64_t e : elements) {
    const glm::dvec3 there = expected.u_voxels[element_of(box.voxel(e), size)];
    EXPECT_LT(glm::length(box.displacement_voxels(e) - there), 1e-5);
    furthest = std::max(furthest, glm::length(there));
  }
  EXPECT_GT(furthest, 0.1);
}

// --- with handles

MaterialTable clay_table(double yield_strain) {
  Material m = material(0, 1, 0.4, 2.0, 0.6);
  m.yield_strain = yield_strain;
  return table({m});
}

// A block of clay with its faces held, pulled in its middle.
class Pulled {
 public:
  explicit Pulled(double yield_strain = 0.05, int threads = 1, const DeformerOptions& options = {})
      : pool_(workers(threads)),
        deformer_(constant_volume({15, 14, 13}), clay_table(yield_strain), {63, false}, options) {
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

// The flow of a block of one material by the words of yield_flow.h, solved at once; what does not
// yield and holds on to the corner stays, any other part of that is one unknown.
DisplacementField flow_by_the_book(const Lattice& lattice, double yield_strain) {
  const Size3 size = lattice.grid().volume_size();
  const auto count = static_cast<std::size_t>(voxel_count(size));
  const DisplacementField u = displacements_of(lattice);
  const auto for_each_spring = [&](auto&& f) {
    for_each_voxel(size, [&](VoxelIndex v) {
      for (const glm::ivec3& offset : DenseSprings::kOffsets) {
        const VoxelIndex other = v + offset;
        if (contains(size, other)) f(element_of(v, size), element_of(other, size), offset);
      }
    });
  };
  std::vector<double> shares(count, 0.0);
  for_each_spring([&](std::size_t i, std::size_t j, glm::ivec3 offset) {
    const double rest = glm::length(glm::dvec3(offset));
    const double strain = std::abs(glm::length(glm::dvec3(offset) + u[j] - u[i]) / rest - 1.0);
    if (strain <= yield_strain) return;
    for (const std::size_t e : {i, j}) shares[e] = std::max(shares[e], 1.0 - yield_strain / strain);
  });
  // The lowest element that the springs of those without a share lead to from each of them.
  std::vector<std::size_t> unknown(count);
  for (std::size_t e = 0; e < count; ++e) unknown[e] = e;
  for (bool changed = true; changed;) {
    changed = false;
    for_each_spring([&](std::size_t i, std::size_t j, glm::ivec3) {
      if (shares[i] > 0.0 || shares[j] > 0.0 || unknown[i] == unknown[j]) return;
      unknown[i] = unknown[j] = std::min(unknown[i], unknown[j]);
      changed = true;
    });
  }
  std::vector<Eigen::Triplet<double>> entries;
  const auto n = static_cast<Eigen::Index>(count);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(n, 3);
  for (Eigen::Index e = 0; e < n; ++e) entries.emplace_back(e, e, 1e-12);
  for_each_spring([&](std::size_t i, std::size_t j, glm::ivec3) {
    const auto a = static_cast<Eigen::Index>(unknown[i]);
    const auto b = static_cast<Eigen::Index>(unknown[j]);
    if (a == b) return;
    // A part that goes as one is 1000 times stiffer, in series with what it hangs on.
    const auto goes_as_one = [&](std::size_t e) { return !(shares[e] > 0.0) && unknown[e] != 0; };
    const double k = goes_as_one(i) || goes_as_one(j) ? 2.0 / (1.0 + 1e-3) : 1.0;
    const glm::dvec3 target = 0.5 * k * (shares[i] + shares[j]) * (u[j] - u[i]);
    for (const auto& [here, there, sign] : {std::tuple{a, b, -1.0}, std::tuple{b, a, 1.0}}) {
      if (here == 0) continue;
      entries.emplace_back(here, here, k);
      if (there != 0) entries.emplace_back(here, there, -k);
      for (int c = 0; c < 3; ++c) right(here, c) += sign * target[c];
    }
  });
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(matrix);
  const Eigen::MatrixXd solution = factors.solve(right);
  DisplacementField flow;
  for (const std::size_t at : unknown) {
    const auto row = static_cast<Eigen::Index>(at);
    flow.emplace_back(solution(row, 0), solution(row, 1), solution(row, 2));
  }
  return flow;
}

TEST(Yield, FlowsByTheBook) {
  for (const double yield_strain : {0.02, 0.05, 0.15}) {
    Pulled block(yield_strain);
    block.relax();
    const Deformer& deformer = block.deformer();
    const YieldFlow flow = let_yield({deformer.lattice(), deformer.kept(), deformer.materials(),
                                      deformer.cuts(), std::int64_t{1} << 30},
                                     workers(2));
    const DisplacementField expected = flow_by_the_book(deformer.lattice(), yield_strain);
    const std::vector<std::uint8_t> nothing_held(expected.size(), 0);
    const DisplacementField rest(expected.size(), glm::dvec3(0));
    EXPECT_GT(distance_of(expected, rest, nothing_held).largest, 0.5);
    EXPECT_LT(distance_of(displacements_of(flow.kept), expected, nothing_held).largest,
              1e-3 + 0.87 * kUnit)
        << yield_strain;
  }
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

// With all the memory it wants, or so little that what undo holds goes to the scratch file.
class YieldUndo : public ::testing::TestWithParam<std::optional<std::int64_t>> {};
INSTANTIATE_TEST_SUITE_P(Memory, YieldUndo,
                         ::testing::Values(std::nullopt, std::int64_t{512} << 10));

TEST_P(YieldUndo, BringsBackWhatWasKept) {
  Pulled block(0.05, 1, {.lattice_memory_bytes = GetParam()});
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
  if (GetParam()) {
    EXPECT_GT(deformer.memory()->store().counters().planes_written, 0);
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
