// Rounding that stiff springs mind, against the energy that the reference gives to both roundings.
#include "deform/settle_rounding.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "references/dense_springs.h"
#include "tests/deform/relaxing.h"

namespace maille {
namespace {

using testing::for_each_voxel;
using testing::RelaxationScene;
using testing::springy;
using testing::workers;

constexpr Size3 kSize{14, 13, 12};

// 1 in a ball, 0 around it.
Volume ball_volume(glm::dvec3 spacing_mm) {
  std::vector<std::uint8_t> samples;
  for_each_voxel(kSize, [&](VoxelIndex v) {
    samples.push_back(glm::length(glm::dvec3(v) - glm::dvec3(6)) < 4.5);
  });
  return Volume::of(kSize, VoxelType::uint8, axis_aligned(spacing_mm), std::move(samples));
}

// A stiff ball, turned by a little in soft surroundings, in floats that no fixed point is.
class TurnedBall {
 public:
  TurnedBall()
      : volume_(ball_volume({1, 0.6, 2})), scene_(volume_, {springy(0, 1.0), springy(1, 1000.0)}) {
    scene_.hold([](VoxelIndex v) { return v == VoxelIndex(6, 6, 6); });
    box_ = std::make_unique<SpringBox>(
        SpringBox::Problem{scene_.start, scene_.field, scene_.cuts, scene_.held, scene_.anchors},
        VoxelBox{{}, kSize}, workers());
    for_each_voxel(kSize, [&](VoxelIndex v) {
      const std::int64_t e = box_->element(v);
      if (!box_->is_free(e)) return;
      const glm::dvec3 from = (glm::dvec3(v) - glm::dvec3(6)) * volume_.spacing_mm();
      const glm::dvec3 by = glm::cross(glm::dvec3(0.003, -0.007, 0.011), from);
      for (int c = 0; c < 3; ++c) {
        box_->u_mm()[static_cast<std::size_t>(c)][e] = static_cast<float>(by[c]);
      }
    });
  }
  const SpringBox& box() const { return *box_; }
  BoxVectors rounded() const {
    BoxVectors mm = make_box_vectors(box_->extent(), workers());
    box_->round_to_fixed_point(mm, workers());
    return mm;
  }
  double energy(const BoxVectors& mm) const {
    const SpringProblem twin = scene_.twin();
    DisplacementField u(twin.start_voxels.size());
    for_each_voxel(kSize, [&](VoxelIndex v) {
      const std::int64_t e = box_->element(v);
      for (int c = 0; c < 3; ++c) {
        u[static_cast<std::size_t>(linear_index(v, kSize))][c] =
            double{mm[static_cast<std::size_t>(c)][e]};
      }
    });
    return DenseSprings(twin, workers()).energy(u);
  }

 private:
  Volume volume_;
  RelaxationScene scene_;
  std::unique_ptr<SpringBox> box_;
};

TEST(SettleRounding, TakesMostOfTheEnergyThatRoundingAdds) {
  TurnedBall ball;
  BoxVectors mm = ball.rounded();
  const double exact = ball.energy(ball.box().u_mm());
  const double nearest = ball.energy(mm);
  settle_rounding(ball.box(), {}, mm, workers());
  const double settled = ball.energy(mm);
  ASSERT_GT(nearest, 1.01 * exact) << "nothing to win";
  EXPECT_LT(settled - exact, 0.5 * (nearest - exact));
}

TEST(SettleRounding, StaysWithinAUnitInFixedPointAndLeavesWhatIsHeld) {
  TurnedBall ball;
  const BoxVectors before = ball.rounded();
  BoxVectors mm = ball.rounded();
  settle_rounding(ball.box(), {}, mm, workers());
  for_each_voxel(kSize, [&](VoxelIndex v) {
    const std::int64_t e = ball.box().element(v);
    for (std::size_t c = 0; c < 3; ++c) {
      const double unit_mm = ball.box().spacing_mm()[static_cast<int>(c)] / kUnitsPerVoxel;
      const double units = double{mm[c][e]} / unit_mm;
      EXPECT_NEAR(units, std::round(units), 1e-4);
      EXPECT_LE(std::abs(double{mm[c][e]} - double{ball.box().u_mm()[c][e]}), 1.0001 * unit_mm);
      if (!ball.box().is_free(e)) {
        EXPECT_EQ(mm[c][e], before[c][e]);
      }
    }
  });
}

TEST(SettleRounding, LeavesTheElementsOfTheCornersGiven) {
  TurnedBall ball;
  const BoxVectors before = ball.rounded();
  BoxVectors mm = ball.rounded();
  const FoldEnergy folds(ball.box());
  std::vector<CellCorner> kept;
  for_each_voxel(kSize, [&](VoxelIndex v) {
    if (v.z < 6)
      folds.for_each_corner_at(ball.box().element(v),
                               [&](const CellCorner& corner) { kept.push_back(corner); });
  });
  settle_rounding(ball.box(), kept, mm, workers());
  int moved = 0;
  for_each_voxel(kSize, [&](VoxelIndex v) {
    const std::int64_t e = ball.box().element(v);
    for (std::size_t c = 0; c < 3; ++c) {
      if (v.z < 6) {
        EXPECT_EQ(mm[c][e], before[c][e]);
      }
      moved += mm[c][e] != before[c][e];
    }
  });
  EXPECT_GT(moved, 20);
}

TEST(SettleRounding, SameBitsForAnyNumberOfThreads) {
  TurnedBall ball;
  BoxVectors first = ball.rounded();
  settle_rounding(ball.box(), {}, first, workers());
  for (const int threads : {1, 3, 8}) {
    WorkerPool pool(threads);
    BoxVectors mm = ball.rounded();
    settle_rounding(ball.box(), {}, mm, pool);
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::int64_t e = 0; e < voxel_count(ball.box().extent()); ++e) {
        ASSERT_EQ(mm[c][e], first[c][e]) << threads << " threads";
      }
    }
  }
}

// Where the last states' rounded energies tell nothing of where they are, what is given out must
// not stay behind.
TEST(SettleRounding, LetsARelaxationGiveOutWhatItFound) {
  RelaxationScene scene(ball_volume({1, 3, 10}), {springy(0, 1.0), springy(1, 1000.0)});
  scene.displace([](VoxelIndex v) {
    return v == VoxelIndex(8, 6, 6) ? glm::dvec3(1.5, 0.5, 0.2) : glm::dvec3(0);
  });
  scene.anchors = {};
  scene.hold([](VoxelIndex v) { return v == VoxelIndex(8, 6, 6); });
  Relaxation relaxation = scene.relaxation(workers(2));
  testing::run(relaxation, 1000);
  ASSERT_TRUE(relaxation.progress().converged);
  SpringProblem twin = scene.twin();
  twin.start_voxels = relaxation.displacements_voxels();
  const Equilibrium expected = spring_equilibrium(twin, workers());
  ASSERT_TRUE(expected.converged);
  EXPECT_LT(testing::distance_of(testing::displacements_of(relaxation.lattice()), expected.u_voxels,
                                 twin.held)
                .largest,
            0.01);
}

}  // namespace
}  // namespace maille
