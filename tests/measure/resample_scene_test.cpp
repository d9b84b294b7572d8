#include "measure/resample_scene.h"

#include <cmath>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "measure/resample_truth.h"

namespace maille {
namespace {

ResampleScene scene_of(const std::string& name, int edge = 128) {
  for (const ResampleScene& scene : resample_scenes(edge)) {
    if (scene.name == name) return scene;
  }
  throw std::out_of_range(name);
}

// Rest positions spread over a volume.
template <class F>
void for_some_places(double edge, F&& f) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> along(0.0, edge);
  for (int i = 0; i < 2000; ++i) {
    const double x = along(random);
    const double y = along(random);
    f(glm::dvec3(x, y, along(random)));
  }
}

TEST(ResampleScene, GradientsAreThoseOfTheDisplacements) {
  constexpr double kStep = 1e-5;
  for (const ResampleScene& scene : resample_scenes(128)) {
    SCOPED_TRACE(scene.name);
    for_some_places(127.0, [&](glm::dvec3 at) {
      const glm::dmat3 gradient = scene.displacement(at).gradient;
      for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 step(0);
        step[axis] = kStep;
        const glm::dvec3 slope =
            (scene.displacement(at + step).u - scene.displacement(at - step).u) / (2.0 * kStep);
        ASSERT_LT(glm::length(slope - gradient[axis]), 1e-7);
      }
    });
  }
}

TEST(ResampleScene, TheyDoWhatTheirTitlesSay) {
  double steepest = 0.0;
  double least_stretch = 4.0, most_stretch = 0.0;
  double least_determinant = 1.0;
  const ResampleScene mild = scene_of("mild");
  const ResampleScene local = scene_of("stretched_locally");
  const ResampleScene near = scene_of("near_folding");
  for_some_places(127.0, [&](glm::dvec3 at) {
    const glm::dmat3 waves = mild.displacement(at).gradient;
    for (int a = 0; a < 3; ++a) {
      for (int c = 0; c < 3; ++c) steepest = std::max(steepest, std::abs(waves[a][c]));
    }
    const double stretch = 1.0 + local.displacement(at).gradient[0][0];
    least_stretch = std::min(least_stretch, stretch);
    most_stretch = std::max(most_stretch, stretch);
    least_determinant = std::min(least_determinant,
                                 glm::determinant(glm::dmat3(1) + near.displacement(at).gradient));
  });
  EXPECT_LE(steepest, 0.3 + 1e-12);
  EXPECT_GT(steepest, 0.2);
  EXPECT_NEAR(most_stretch, 4.0, 0.01);
  EXPECT_NEAR(least_stretch, 0.25, 0.01);
  EXPECT_GT(least_determinant, 0.04);
  EXPECT_LT(least_determinant, 0.06);
  // Its ends stay, but for the part of a voxel that all of it is moved by.
  const double low = local.displacement({0, 5, 5}).u.x;
  const double high = local.displacement({127, 5, 5}).u.x;
  EXPECT_NEAR(low, high, 1e-9);
  EXPECT_NEAR(low, 3.0 / 32.0, 1e-9);
}

TEST(ResampleScene, AffineOnesAreExactInTheLattice) {
  WorkerPool pool(2);
  const Size3 size(37, 33, 5);
  for (const char* const name : {"rest", "shifted", "stretched", "squeezed", "sheared"}) {
    SCOPED_TRACE(name);
    const ResampleScene scene = scene_of(name, 37);
    const Lattice lattice = lattice_of(scene, size, pool);
    for (const VoxelIndex voxel : {VoxelIndex(0), VoxelIndex(36, 32, 4), VoxelIndex(7, 31, 2)}) {
      EXPECT_EQ(lattice.displacement_voxels(voxel), scene.displacement(glm::dvec3(voxel)).u);
    }
  }
}

TEST(ResampleScene, NewtonFindsWhereAPointWas) {
  for (const char* const name : {"mild", "stretched_locally", "near_folding", "sheared"}) {
    SCOPED_TRACE(name);
    const ResampleScene scene = scene_of(name);
    for_some_places(127.0, [&](glm::dvec3 rest) {
      const glm::dvec3 point = rest + scene.displacement(rest).u;
      const auto found = rest_by_newton(scene, point, point);
      ASSERT_TRUE(found);
      ASSERT_LT(glm::length(*found - rest), 1e-7);
      ASSERT_LE(glm::length(*found + scene.displacement(*found).u - point), kTruth_voxels);
    });
  }
}

TEST(ResampleScene, NewtonSaysWhereThereIsNothing) {
  // All of it in the plane x = 0.
  ResampleScene flat{"flat", "", {}, {}};
  flat.displacement = [](glm::dvec3 p) {
    return Displacement{{-p.x, 0, 0}, glm::dmat3(-1, 0, 0, 0, 0, 0, 0, 0, 0)};
  };
  EXPECT_FALSE(rest_by_newton(flat, {3, 0, 0}, {3, 0, 0}));
}

TEST(ResampleScene, FoldsHaveAllTheirAnswers) {
  const ResampleScene scene = scene_of("folded");
  int most = 0;
  for (int x = 20; x < 100; ++x) {
    const glm::dvec3 point(x, 40, 50);
    const auto answers = scene.rest_positions(point);
    ASSERT_EQ(answers.size() % 2, 1u) << "each turn adds two";
    most = std::max(most, static_cast<int>(answers.size()));
    for (const glm::dvec3& rest : answers) {
      EXPECT_LT(glm::length(rest + scene.displacement(rest).u - point), 1e-12);
    }
    // As many as how often x(X) passes the point, counted by walking along it.
    int passed = 0;
    const auto beyond = [&](double rest) {
      return rest + scene.displacement({rest, 0, 0}).u.x > point.x;
    };
    for (double rest = -20.0; rest < 150.0; rest += 0.01) {
      passed += beyond(rest) != beyond(rest + 0.01);
    }
    EXPECT_EQ(static_cast<int>(answers.size()), passed) << x;
  }
  EXPECT_EQ(most, 3);
}

TEST(ResampleTruth, OfAShiftIsTheVolumeElsewhere) {
  WorkerPool pool(2);
  const Size3 size(12, 10, 8);
  std::vector<double> values;
  for (std::size_t i = 0; i < 960; ++i) values.push_back(static_cast<double>(i));
  const ResampleTruth truth(whole_shift_scene("", "", {3, -2, 1}), size, values, pool);
  EXPECT_EQ(truth.judged_voxels(), 9 * 8 * 7);
  EXPECT_EQ(truth.lost_voxels(), 0);
  EXPECT_EQ(truth.worst_forward_voxels(), 0.0);
  EXPECT_EQ(truth.bounds(), (VoxelBox{{3, 0, 1}, {12, 8, 8}}));
  const auto at = [&](VoxelIndex voxel) {
    return truth.answers(static_cast<std::size_t>(linear_index(voxel, size)));
  };
  EXPECT_TRUE(at({2, 4, 4}).empty());
  ASSERT_EQ(at({5, 4, 4}).size(), 1u);
  EXPECT_EQ(at({5, 4, 4})[0].rest_voxels, glm::dvec3(2, 6, 3));
  EXPECT_EQ(at({5, 4, 4})[0].interpolated, static_cast<double>(linear_index({2, 6, 3}, size)));
  EXPECT_EQ(at({5, 4, 4})[0].value, static_cast<float>(analytic_value({2, 6, 3})));
}

TEST(ResampleTruth, SaysWhatItDidNotFind) {
  WorkerPool pool(1);
  ResampleScene flat{"flat", "", {}, {}};
  flat.displacement = [](glm::dvec3 p) {
    return Displacement{{-p.x, 0, 0}, glm::dmat3(-1, 0, 0, 0, 0, 0, 0, 0, 0)};
  };
  const Size3 size(4, 3, 2);
  const ResampleTruth truth(flat, size, std::vector<double>(24, 0.5), pool);
  EXPECT_EQ(truth.lost_voxels(), 3 * 3 * 2) << "all but where all of it lies";
}

TEST(ResampleDeviation, IsToTheNearestAnswerAndCountsWhatIsNotShown) {
  WorkerPool pool(2);
  // Everything twice: at its place, and mirrored.
  ResampleScene twice{"twice", "", {}, {}};
  const Size3 size(10, 3, 3);
  twice.displacement = [](glm::dvec3) { return Displacement(); };
  twice.rest_positions = [](glm::dvec3 p) {
    return std::vector{p, glm::dvec3(9.0 - p.x, p.y, p.z)};
  };
  const std::vector<double> values(90, 0.25);
  const ResampleTruth truth(twice, size, values, pool);
  ASSERT_EQ(truth.judged_voxels(), 90);
  std::vector<float> shown;
  std::vector<glm::vec3> rest;
  for (int z = 0; z < 3; ++z) {
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < 10; ++x) {
        const int at = y == 1 ? x : 9 - x;  // now the one, now the other
        shown.push_back(static_cast<float>(analytic_value({at, y, z})));
        rest.emplace_back(at, y, z);
      }
    }
  }
  const VoxelBox whole{VoxelIndex(0), size};
  const auto exact = deviation_from(truth, size, whole, shown, rest, pool);
  EXPECT_EQ(exact.value.max(), 0.0);
  EXPECT_EQ(exact.rest_voxels.max(), 0.0);
  EXPECT_EQ(exact.value.count(), 90);
  ASSERT_TRUE(exact.times_floor());
  EXPECT_EQ(*exact.times_floor(), 0.0);

  shown[41] = 3.0f;
  shown[7] = NAN;
  rest[12].y += 2.0f;
  const auto off = deviation_from(truth, size, whole, shown, rest, pool);
  const VoxelIndex there(1, 1, 1);
  const double by = 3.0 - std::max(analytic_value({1, 1, 1}), analytic_value({8, 1, 1}));
  ASSERT_EQ(linear_index(there, size), 41);
  EXPECT_NEAR(off.value.max(), by, 1e-6);
  EXPECT_NEAR(off.value.rms(), by / std::sqrt(89.0), 1e-6);
  EXPECT_EQ(off.unfilled_voxels, 1);
  EXPECT_EQ(off.value.count(), 89);
  EXPECT_EQ(off.rest_voxels.max(), 2.0);
  EXPECT_NEAR(off.rest_voxels.rms(), 2.0 / std::sqrt(90.0), 1e-12);

  // A part of the volume, in an order of its own.
  const VoxelBox corner{{8, 2, 1}, {10, 3, 3}};
  std::vector<float> four;
  for (int z = 1; z < 3; ++z) {
    for (int x = 8; x < 10; ++x) four.push_back(static_cast<float>(analytic_value({x, 2, z})));
  }
  four[2] += 0.125f;
  const auto part = deviation_from(truth, size, corner, four, {}, pool);
  EXPECT_EQ(part.value.count(), 4);
  EXPECT_EQ(part.rest_voxels.count(), 0);
  EXPECT_EQ(part.value.rms(), part.value.max() / 2.0) << "one of four";
  EXPECT_GT(part.value.max(), 0.0);
}

TEST(Deviation, KeepsWhatIsNoNumber) {
  Deviation all;
  all.add(3.0);
  all.add(4.0);
  EXPECT_EQ(all.rms(), std::sqrt(12.5));
  EXPECT_EQ(all.max(), 4.0);
  Deviation part;
  part.add(NAN);
  part.add(1.0);
  all.add(part);
  EXPECT_TRUE(std::isnan(all.rms()));
  EXPECT_TRUE(std::isnan(all.max()));
  EXPECT_EQ(all.count(), 4);
  EXPECT_EQ(Deviation().rms(), 0.0);
}

}  // namespace
}  // namespace maille
