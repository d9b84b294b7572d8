// Every voxel of random deformed volumes against all that could lie there, in double precision.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "references/nearest_brute_force.h"
#include "tests/resample/faults.h"
#include "tests/resample/random_scenes.h"
#include "tests/resample/resampled.h"
#include "tests/resample/true_answers.h"

namespace maille {
namespace {

using namespace testing;

// Whether a voxel this near to the end of the material has something is rounding.
constexpr double kEnd_voxels = 1e-3;
constexpr double kRest_voxels = 1e-3;

class Voxels : public ::testing::TestWithParam<std::tuple<Shape, unsigned>> {
 protected:
  Voxels()
      : scene_(random_scene(std::get<0>(GetParam()), std::get<1>(GetParam()))),
        truth_(scene_.lattice) {}

  // Whether it can be that nothing is shown where a voxel is, or that something is.
  bool rightly_empty(VoxelIndex v) const {
    const auto answers = truth_.at(v);
    return answers.rest.empty() || truth_.may_be_uncovered(v, kEnd_voxels);
  }
  bool rightly_filled(VoxelIndex v) const {
    const auto answers = truth_.at(v);
    return !answers.rest.empty() || truth_.may_be_covered(v, kEnd_voxels);
  }

  RandomScene scene_;
  TrueAnswers truth_;
};

// Whatever folds: of all elements none lies nearer than the one whose value is shown.
TEST_P(Voxels, ShowTheNearestOfAllElements) {
  const Volume volume = numbered(scene_.size, scene_.spacing_mm);
  const auto out = resampled(volume, scene_.lattice, Cuts(scene_.size), ResampleMethod::nearest);
  const DeformedElements elements(scene_.size, scene_.spacing_mm, displacements_of(scene_.lattice));
  const NearestBruteForce all(elements);
  Faults further;
  Faults missing;
  Faults beyond;
  for_each_voxel(scene_.size, [&](VoxelIndex v) {
    const double value = out.volume.value_at(v);
    if (value == kBackground) {
      if (!rightly_empty(v)) missing.add(text(v));
      return;
    }
    if (!rightly_filled(v)) beyond.add(text(v));
    const glm::dvec3 here_mm = glm::dvec3(v) * scene_.spacing_mm;
    const auto found = static_cast<std::size_t>(value);
    const ElementDistance nearest = all.nearest_to(here_mm);
    const double mine_mm = std::sqrt(elements.distance(found, here_mm).squared_mm2);
    const double least_mm = std::sqrt(nearest.squared_mm2);
    // Floats may take the other of two that are as near.
    if (mine_mm <= least_mm + 2e-5 * (1.0 + least_mm)) return;
    further.add(text(v), ": element ", found, " at ", mine_mm, " mm, not ", nearest.element, " at ",
                least_mm);
  });
  EXPECT_EQ(further.count(), 0) << further.first();
  EXPECT_EQ(missing.count(), 0) << missing.first();
  EXPECT_EQ(beyond.count(), 0) << beyond.first();
}

// Where nothing folds there is one point that lies at a voxel; elsewhere it is one of them.
TEST_P(Voxels, ShowAPointThatLiesThere) {
  const std::vector<float> values = [&] {
    Chance chance(1000 + std::get<1>(GetParam()));
    std::vector<float> all;
    for_each_voxel(scene_.size, [&](VoxelIndex) {
      all.push_back(static_cast<float>(chance.between(0.0, 1.0)));
    });
    return all;
  }();
  const Volume volume =
      Volume::of(scene_.size, VoxelType::float32, axis_aligned(scene_.spacing_mm), values);
  const auto out = resampled(volume, scene_.lattice, Cuts(scene_.size), ResampleMethod::linear);
  const std::vector<glm::vec3> rest = rest_positions(volume, scene_.lattice, Cuts(scene_.size));
  Faults off;
  Faults other;
  Faults missing;
  Faults beyond;
  Faults wrong_value;
  std::int64_t filled = 0;
  std::int64_t unsure = 0;
  std::size_t i = 0;
  for_each_voxel(scene_.size, [&](VoxelIndex v) {
    const glm::dvec3 at(rest[i++]);
    const double value = out.volume.value_at(v);
    if ((value == kBackground) != std::isnan(at.x)) wrong_value.add(text(v), ": ", value);
    if (std::isnan(at.x)) {
      if (!rightly_empty(v)) missing.add(text(v));
      return;
    }
    ++filled;
    const double off_voxels = glm::distance(moved(scene_.lattice, at), glm::dvec3(v));
    if (!(off_voxels <= kRest_voxels)) {
      off.add(text(v), ": ", text(at), " lies ", off_voxels, " voxels away");
    }
    const double expected = trilinear(volume, at);
    if (!(std::abs(value - expected) <= 1e-4)) {
      wrong_value.add(text(v), ": ", value, " not ", expected);
    }
    const auto answers = truth_.at(v);
    unsure += answers.unsure;
    if (answers.rest.empty()) {
      if (!truth_.may_be_covered(v, kEnd_voxels)) beyond.add(text(v));
    } else if (!scene_.folds) {
      ASSERT_EQ(answers.rest.size(), 1u) << text(v);
      // Nothing is squeezed to less than a 25th.
      if (!(glm::distance(answers.rest[0], at) <= 25 * kRest_voxels)) {
        other.add(text(v), ": ", text(at), " not ", text(answers.rest[0]));
      }
    }
  });
  EXPECT_EQ(off.count(), 0) << off.first();
  EXPECT_EQ(other.count(), 0) << other.first();
  EXPECT_EQ(missing.count(), 0) << missing.first();
  EXPECT_EQ(beyond.count(), 0) << beyond.first();
  EXPECT_EQ(wrong_value.count(), 0) << wrong_value.first();
  EXPECT_GT(filled, voxel_count(scene_.size) / 20);
  EXPECT_LE(unsure, filled / 50);
}

// The reference itself: of where a point has got to, that point is an answer.
TEST_P(Voxels, HaveEveryPointThatIsCarriedThereAmongTheirAnswers) {
  Chance chance(2000 + std::get<1>(GetParam()));
  Faults lost;
  int unsure = 0;
  int found = 0;
  for (int i = 0; i < 500; ++i) {
    const glm::dvec3 start = 0.5 * glm::dvec3(scene_.size - 1) +
                             (0.5 * glm::dvec3(scene_.size) - 1e-6) * chance.vector(1.0);
    const glm::dvec3 now = moved(scene_.lattice, start);
    if (!contains(scene_.size, VoxelIndex(glm::round(now)))) continue;
    const auto answers = truth_.at(now);
    unsure += answers.unsure;
    const bool known = std::any_of(answers.rest.begin(), answers.rest.end(),
                                   [&](glm::dvec3 at) { return glm::distance(at, start) < 1e-5; });
    found += known;
    if (!known && !answers.unsure) lost.add(text(start), " at ", text(now));
  }
  EXPECT_EQ(lost.count(), 0) << lost.first();
  EXPECT_GT(found, 20);
  EXPECT_LE(unsure, 10);
}

// Its u is linear in the tetrahedra around a cell's diagonal: in the order of t's components, from
// the largest on.
glm::dvec3 moved_by_tetrahedra(const Lattice& lattice, glm::dvec3 rest) {
  const Size3 size = lattice.grid().volume_size();
  const glm::dvec3 inside = glm::clamp(rest, glm::dvec3(0), glm::dvec3(size - 1));
  const VoxelIndex base =
      glm::max(glm::min(VoxelIndex(glm::floor(inside)), size - 2), VoxelIndex(0));
  const glm::dvec3 t = inside - glm::dvec3(base);
  int axes[] = {0, 1, 2};
  std::sort(std::begin(axes), std::end(axes), [&](int a, int b) { return t[a] > t[b]; });
  VoxelIndex corner = base;
  glm::dvec3 at = rest + (1.0 - t[axes[0]]) * lattice.displacement_voxels(corner);
  for (int i = 0; i < 3; ++i) {
    ++corner[axes[i]];
    const double weight = t[axes[i]] - (i < 2 ? t[axes[i + 1]] : 0.0);
    if (weight > 0.0) {
      at += weight * lattice.displacement_voxels(glm::min(corner, VoxelIndex(size - 1)));
    }
  }
  return at;
}
TEST_P(Voxels, ShowAPointThatLiesThereByTetrahedra) {
  const Cuts cuts(scene_.size);
  const std::vector<glm::vec3> rest =
      rest_positions(numbered(scene_.size), scene_.lattice, cuts, ResampleMethod::barycentric);
  Faults off;
  std::int64_t filled = 0;
  std::size_t i = 0;
  for_each_voxel(scene_.size, [&](VoxelIndex v) {
    const glm::dvec3 at(rest[i++]);
    if (std::isnan(at.x)) return;
    ++filled;
    const double off_voxels = glm::distance(moved_by_tetrahedra(scene_.lattice, at), glm::dvec3(v));
    if (!(off_voxels <= kRest_voxels)) {
      off.add(text(v), ": ", text(at), " lies ", off_voxels, " voxels away");
    }
  });
  EXPECT_EQ(off.count(), 0) << off.first();
  EXPECT_GT(filled, voxel_count(scene_.size) / 20);
}

INSTANTIATE_TEST_SUITE_P(Smooth, Voxels,
                         ::testing::Combine(::testing::Values(Shape::smooth),
                                            ::testing::Range(1u, 11u)),
                         name_of_scene);
INSTANTIATE_TEST_SUITE_P(Rough, Voxels,
                         ::testing::Combine(::testing::Values(Shape::rough),
                                            ::testing::Range(11u, 21u)),
                         name_of_scene);
INSTANTIATE_TEST_SUITE_P(Steep, Voxels,
                         ::testing::Combine(::testing::Values(Shape::steep),
                                            ::testing::Range(61u, 69u)),
                         name_of_scene);
INSTANTIATE_TEST_SUITE_P(Folded, Voxels,
                         ::testing::Combine(::testing::Values(Shape::folded),
                                            ::testing::Range(21u, 31u)),
                         name_of_scene);
INSTANTIATE_TEST_SUITE_P(Wild, Voxels,
                         ::testing::Combine(::testing::Values(Shape::wild),
                                            ::testing::Range(31u, 35u)),
                         name_of_scene);

}  // namespace
}  // namespace maille
