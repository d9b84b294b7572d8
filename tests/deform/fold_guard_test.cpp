// What keeps cells from folding: its forces against its energy, its energy against the reference's,
// and its promise against steps far too bold.
#include "deform/fold_guard.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "references/dense_problem.h"
#include "tests/deform/spring_row_scenes.h"

namespace maille {
namespace {

using testing::for_each_voxel;
using testing::RelaxationScene;
using testing::springy;
using testing::workers;

// A block shaken by up to `most` voxels, some of it held, cut where asked.
class ShakenBox {
 public:
  ShakenBox(unsigned seed, double most, bool cut, double held_share)
      : scene_(testing::random_volume({9, 8, 10}, 2, 3, seed, {1, 0.7, 1.6}),
               {springy(0, 1.0), springy(1, 20.0)}) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> off(-most, most);
    scene_.displace([&](VoxelIndex) { return glm::dvec3(off(random), off(random), off(random)); });
    scene_.hold([&](VoxelIndex) { return off(random) < most * (2.0 * held_share - 1.0); });
    if (cut) {
      const auto disc = CutSurface::disc({4.3, 4.3, 4.3}, {1, 1, -1}, 4.0, glm::dvec3(1));
      scene_.cuts = *cut_along(scene_.cuts, Lattice(scene_.size()), *disc);
    }
    box_ = std::make_unique<SpringBox>(
        SpringBox::Problem{scene_.start, scene_.field, scene_.cuts, scene_.held, scene_.anchors},
        VoxelBox{{}, scene_.size()}, workers());
  }

  SpringBox& box() { return *box_; }
  const RelaxationScene& scene() const { return scene_; }

  // Of numbers that a direction keeps as they are.
  BoxVectors random_direction(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> along(-1, 1);
    BoxVectors d = make_box_vectors(box_->extent(), workers());
    for_each_free([&](std::int64_t e) {
      for (auto& c : d) c[e] = along(random);
    });
    static_cast<void>(testing::keep_as_direction(d, box_->extent(), workers()));
    return d;
  }
  BoxDirection as_direction(BoxVectors& d) const {
    return testing::keep_as_direction(d, box_->extent(), workers());
  }
  template <class F>
  void for_each_free(F&& f) const {
    for (std::int64_t e = 0; e < voxel_count(box_->extent()); ++e) {
      if (box_->is_free(e)) f(e);
    }
  }
  void add(double share, const BoxVectors& d) {
    for_each_free([&](std::int64_t e) {
      for (std::size_t c = 0; c < 3; ++c) box_->u_mm()[c][e] += static_cast<float>(share) * d[c][e];
    });
  }
  // The determinants of all corners that count.
  std::vector<double> determinants() const {
    const FoldEnergy folds(*box_);
    std::vector<double> all;
    for (std::int64_t e = 0; e < voxel_count(box_->extent()); ++e) {
      for (std::uint8_t signs = 0; signs < 8; ++signs) {
        if (folds.counts({e, signs})) all.push_back(folds.determinant({e, signs}));
      }
    }
    return all;
  }
  std::set<std::int64_t> folded_cells() const {
    const FoldEnergy folds(*box_);
    std::set<std::int64_t> cells;
    for (std::int64_t e = 0; e < voxel_count(box_->extent()); ++e) {
      for (std::uint8_t signs = 0; signs < 8; ++signs) {
        const CellCorner corner{e, signs};
        if (folds.counts(corner) && folds.determinant(corner) <= 0.0) {
          cells.insert(folds.cell_of(corner));
        }
      }
    }
    return cells;
  }
  DisplacementField u_mm() const {
    DisplacementField u;
    for_each_voxel(scene_.size(), [&](VoxelIndex v) {
      u.push_back(box_->displacement_voxels(box_->element(v)) * box_->spacing_mm());
    });
    return u;
  }

 private:
  RelaxationScene scene_;
  std::unique_ptr<SpringBox> box_;
};

double least_of(const std::vector<double>& all) { return *std::ranges::min_element(all); }

TEST(FoldPenalty, IsSmoothAndStraightBelow) {
  constexpr double kFloor = kFoldFloor * kFoldReach;
  for (double j = -1.0004; j < 0.5; j += 0.0013) {
    const double kStep = 1e-4 * std::max(kFloor, std::abs(j));
    const auto at = fold_penalty(j);
    const double slope =
        (fold_penalty(j + kStep).value - fold_penalty(j - kStep).value) / (2 * kStep);
    EXPECT_NEAR(at.slope / kFoldReach, slope, 1e-4 * (1.0 + std::abs(slope))) << j;
    const double curvature =
        (fold_penalty(j + kStep).slope - fold_penalty(j - kStep).slope) / (2 * kStep);
    EXPECT_NEAR(at.curvature / kFoldReach, curvature, 1e-4 * (1.0 + std::abs(curvature))) << j;
  }
  // The wall is left no higher than it was.
  EXPECT_NEAR(fold_penalty(kFloor * (1 - 1e-9)).value, fold_penalty(kFloor * (1 + 1e-9)).value,
              1e-6);
  EXPECT_GT(fold_penalty(-1.0).value, fold_penalty(0.0).value);
  EXPECT_EQ(fold_penalty(kFoldReach).value, 0.0);
}

TEST(FoldGuard, EnergyIsTheReferences) {
  for (const bool cut : {false, true}) {
    for (const unsigned seed : {1u, 2u, 3u}) {
      ShakenBox shaken(seed, 0.15 + 0.1 * seed, cut, 0.0);
      const FoldGuard guard(shaken.box(), workers());
      const SpringProblem twin = shaken.scene().twin();
      const DenseSprings springs(twin, workers());
      const double expected = springs.fold_energy(shaken.u_mm());
      EXPECT_GT(expected, 0.0);
      EXPECT_NEAR(guard.energy(), expected, 1e-5 * expected);
    }
  }
}

// Nothing is near the wall: so steep a thing cannot be told from floats (IsSmoothAndStraightBelow).
TEST(FoldGuard, ForcesAndCurvatureAreThoseOfItsEnergy) {
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    constexpr double kWall = kFoldWall * kFoldReach;
    double most = 0.4;
    while (least_of(ShakenBox(seed, most, seed % 2 == 0, 0.2).determinants()) < 1.3 * kWall) {
      most *= 0.97;
    }
    ShakenBox shaken(seed, most, seed % 2 == 0, 0.2);
    ASSERT_LT(least_of(shaken.determinants()), 0.7 * kFoldReach);
    BoxVectors d = shaken.random_direction(seed);
    const FoldGuard here(shaken.box(), workers());
    BoxVectors forces = make_box_vectors(shaken.box().extent(), workers());
    here.add_forces(forces);
    double slope = 0.0;
    double size = 0.0;
    shaken.for_each_free([&](std::int64_t e) {
      for (std::size_t c = 0; c < 3; ++c) {
        slope -= double{forces[c][e]} * double{d[c][e]};
        size += std::abs(double{forces[c][e]} * double{d[c][e]});
      }
    });
    const double curvature = here.curvature(shaken.as_direction(d));
    const double energy = here.energy();
    // A state is known to a ten-millionth, so the steps cannot be small.
    constexpr double kStep = 1e-3;
    shaken.add(kStep, d);
    const double up = FoldGuard(shaken.box(), workers()).energy();
    shaken.add(-2 * kStep, d);
    const double down = FoldGuard(shaken.box(), workers()).energy();
    EXPECT_NEAR((up - down) / (2 * kStep), slope, 2e-4 * size);
    EXPECT_NEAR((up - 2 * energy + down) / (kStep * kStep), curvature,
                0.02 * std::abs(curvature) + 0.02 * size);
  }
}

// From a state without a fold none appears, however far the step would go.
TEST(FoldGuard, NeverFoldsWhatIsOpen) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    ShakenBox shaken(seed, 0.1, seed % 3 == 0, 0.3);
    ASSERT_GT(least_of(shaken.determinants()), 0.0);
    FoldGuard guard(shaken.box(), workers());
    for (int steps = 0; steps < 6; ++steps) {
      const BoxVectors d = shaken.random_direction(seed * 10 + static_cast<unsigned>(steps));
      const double step = std::pow(10.0, steps - 3);
      guard.advance(d, step, std::sqrt(3.0) / 0.7, 0.0);
      const auto determinants = shaken.determinants();
      EXPECT_GT(least_of(determinants), 0.0) << seed << ", step " << step;
      EXPECT_EQ(guard.folded(), 0);
      std::int64_t bent = 0;
      for (const double j : determinants) bent += j < kFoldReach;
      EXPECT_EQ(static_cast<std::int64_t>(guard.bent().size()), bent) << seed << ", step " << step;
    }
  }
}

// A leap that folds cells either opens them all or did not happen.
TEST(FoldGuard, LeapsOrStaysWhereItWas) {
  int opened = 0;
  int stayed = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    ShakenBox shaken(seed, 0.1, seed % 3 == 0, 0.1);
    ASSERT_GT(least_of(shaken.determinants()), 0.0);
    FoldGuard guard(shaken.box(), workers());
    const DisplacementField before = shaken.u_mm();
    BoxVectors d = shaken.random_direction(seed);
    const double size = 0.2 + 0.1 * (seed % 10);
    for (auto& component : d) {
      for (std::int64_t e = 0; e < voxel_count(shaken.box().extent()); ++e) {
        component[e] *= static_cast<float>(size);
      }
    }
    shaken.add(1.0, d);
    const bool folds = least_of(shaken.determinants()) <= 0.0;
    shaken.add(-1.0, d);
    const DisplacementField still = shaken.u_mm();
    BoxVectors scratch = make_box_vectors(shaken.box().extent(), workers());
    if (guard.leap(d, size * std::sqrt(3.0) / 0.7, 0.0, scratch)) {
      opened += folds;
      EXPECT_FALSE(shaken.u_mm() == before) << seed;
    } else {
      ++stayed;
      EXPECT_TRUE(shaken.u_mm() == still) << seed;
    }
    // Whatever it measured on its way, it knows the state that it left.
    for (const double step : {0.0, 0.3}) {
      guard.advance(d, step, size * std::sqrt(3.0) / 0.7, 0.0);
      const auto determinants = shaken.determinants();
      EXPECT_GT(least_of(determinants), 0.0) << seed;
      EXPECT_EQ(guard.folded(), 0);
      std::int64_t bent = 0;
      for (const double j : determinants) bent += j < kFoldReach;
      EXPECT_EQ(static_cast<std::int64_t>(guard.bent().size()), bent) << seed;
    }
  }
  EXPECT_GT(opened, 0);
  EXPECT_GT(stayed, 0);
}

// And from one with folds only fewer are left: no open cell folds, others open again.
TEST(FoldGuard, LeavesFewerFolds) {
  std::int64_t before = 0;
  std::int64_t after = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    ShakenBox shaken(seed, 0.5, seed % 3 == 0, 0.1);
    const auto was = shaken.folded_cells();
    FoldGuard guard(shaken.box(), workers());
    std::int64_t folded = 0;
    for (const double j : shaken.determinants()) folded += j <= 0.0;
    EXPECT_EQ(guard.folded(), folded);
    EXPECT_GT(folded, 0);
    const BoxVectors none = make_box_vectors(shaken.box().extent(), workers());
    for (int i = 0; i < 5; ++i) guard.advance(none, 0.0, 0.0, 0.0);
    for (const std::int64_t cell : shaken.folded_cells()) EXPECT_TRUE(was.contains(cell));
    before += folded;
    after += guard.folded();
  }
  EXPECT_LT(after, before / 10) << "of " << before;
}

TEST(FoldGuard, SameBitsForAnyNumberOfThreads) {
  std::optional<DisplacementField> first;
  for (const int threads : {1, 2, 3, 8}) {
    ShakenBox shaken(3, 0.4, true, 0.1);
    WorkerPool pool(threads);
    FoldGuard guard(shaken.box(), pool);
    for (int i = 0; i < 4; ++i) {
      BoxVectors d = shaken.random_direction(9);
      guard.advance(shaken.as_direction(d), 0.2, 3.0, 0.0);
    }
    if (!first) first = shaken.u_mm();
    EXPECT_TRUE(shaken.u_mm() == *first) << threads << " threads";
  }
}

}  // namespace
}  // namespace maille
