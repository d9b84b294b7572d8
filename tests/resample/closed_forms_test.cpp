// Deformations whose answer is known for every voxel, and there and back again where nothing folds.
#include <cmath>

#include <gtest/gtest.h>

#include "tests/resample/faults.h"
#include "tests/resample/random_scenes.h"
#include "tests/resample/resampled.h"
#include "tests/resample/true_answers.h"

namespace maille {
namespace {

using namespace testing;

constexpr Size3 kSize{45, 37, 34};

Volume random_values() {
  Chance chance(8);
  return volume_from<float>(kSize, VoxelType::float32, glm::dvec3(1),
                            [&](VoxelIndex) { return chance.between(0.0, 1.0); });
}

// Where an affine map puts points is exactly what a lattice holds, but for its rounding: to a unit
// of the lattice, and what the inverse makes of it.
void expect_affine(const glm::dmat3& map, glm::dvec3 shift, double tolerance_voxels) {
  const glm::dvec3 center = 0.5 * glm::dvec3(kSize - 1);
  const Lattice lattice =
      lattice_from(kSize, [&](glm::dvec3 p) { return center + shift + map * (p - center) - p; });
  const Volume volume = random_values();
  const Cuts cuts(kSize);
  const auto linear = resampled(volume, lattice, cuts, ResampleMethod::linear);
  const auto nearest = resampled(numbered(kSize), lattice, cuts, ResampleMethod::nearest);
  const std::vector<glm::vec3> rest = rest_positions(volume, lattice, cuts);
  const glm::dmat3 inverse = glm::inverse(map);
  Faults off;
  Faults wrong_value;
  Faults not_nearest;
  Faults beyond;
  std::int64_t inside = 0;
  std::size_t i = 0;
  for_each_voxel(kSize, [&](VoxelIndex v) {
    const glm::dvec3 at(rest[i++]);
    const glm::dvec3 truth = center + inverse * (glm::dvec3(v) - center - shift);
    const glm::dvec3 within = glm::min(truth, glm::dvec3(kSize - 1) - truth);
    const double depth = std::min({within.x, within.y, within.z});
    if (depth < 0.0) {
      // Half a voxel beyond the border, as it was at rest.
      const glm::dvec3 border = glm::clamp(truth, glm::dvec3(0), glm::dvec3(kSize - 1));
      const glm::dvec3 away = glm::dvec3(v) - center - shift - map * (border - center);
      if (glm::length(away) > 0.5 * std::sqrt(3.0) + 0.01 && !std::isnan(at.x)) {
        beyond.add(text(v), ": ", text(at));
      }
      return;
    }
    ++inside;
    if (!(glm::distance(at, truth) <= tolerance_voxels)) {
      off.add(text(v), ": ", text(at), " not ", text(truth));
    }
    const double value = linear.volume.value_at(v);
    if (!(std::abs(value - trilinear(volume, truth)) <= 3 * tolerance_voxels)) {
      wrong_value.add(text(v), ": ", value, " not ", trilinear(volume, truth));
    }
    // No other element than the nearest of the truth's corner is nearer by more than rounding.
    const auto n = static_cast<std::int64_t>(nearest.volume.value_at(v));
    if (n < 0) {
      not_nearest.add(text(v), ": none");
      return;
    }
    const glm::dvec3 found(n % kSize.x, n / kSize.x % kSize.y, n / kSize.x / kSize.y);
    const double mine = glm::length(map * (found - truth));
    double least = mine;
    for_each_voxel(Size3(7), [&](VoxelIndex around) {
      const VoxelIndex e = VoxelIndex(glm::round(truth)) + around - 3;
      if (contains(kSize, e)) least = std::min(least, glm::length(map * (glm::dvec3(e) - truth)));
    });
    if (mine > least + 0.01) not_nearest.add(text(v), ": ", text(found), " for ", text(truth));
  });
  EXPECT_EQ(off.count(), 0) << off.first();
  EXPECT_EQ(wrong_value.count(), 0) << wrong_value.first();
  EXPECT_EQ(not_nearest.count(), 0) << not_nearest.first();
  EXPECT_EQ(beyond.count(), 0) << beyond.first();
  EXPECT_GT(inside, 500);
}

TEST(ClosedForms, Affine) {
  const double c = std::cos(0.4);
  const double s = std::sin(0.4);
  for (const glm::dmat3& map :
       {glm::dmat3(1.0), glm::dmat3(c, s, 0, -s, c, 0, 0, 0, 1),
        glm::dmat3(c, 0, s, 0, 1, 0, -s, 0, c), glm::dmat3(1.5, 0, 0, 0, 0.75, 0, 0, 0, 1),
        glm::dmat3(1, 0, 0, 0.3, 1, 0, -0.2, 0.25, 1), glm::dmat3(4, 0, 0, 0, 1, 0, 0, 0, 1),
        glm::dmat3(1, 0, 0, 0, 0.25, 0, 0, 0, 2)}) {
    // Elements are rounded to half a 512th voxel; what is squeezed 4 times is off 4 times as far.
    const double most = glm::length(glm::inverse(map) * glm::dvec3(1, 1, 1));
    expect_affine(map, glm::dvec3(0.3, -0.45, 0.2), 1.5e-3 * std::max(1.0, most));
  }
}

// Shifts that a lattice holds to the bit.
TEST(ClosedForms, ShiftsOfPartsOfAVoxel) {
  for (const glm::dvec3 shift : {glm::dvec3(0.5, 0, 0), glm::dvec3(0.25, -0.125, 3.5),
                                 glm::dvec3(1.0 / 512, -1.0 / 512, 0), glm::dvec3(-7.375, 0, 2)}) {
    expect_affine(glm::dmat3(1.0), shift, 1e-4);
  }
}

// Turned about an element every element comes to lie on a voxel.
TEST(ClosedForms, QuarterTurnsAreExact) {
  const glm::ivec3 center(20, 18, 17);
  const Volume volume = random_values();
  for (const glm::dmat3& turn :
       {glm::dmat3(0, 1, 0, -1, 0, 0, 0, 0, 1), glm::dmat3(1, 0, 0, 0, 0, 1, 0, -1, 0),
        glm::dmat3(0, 0, -1, 0, 1, 0, 1, 0, 0), glm::dmat3(-1, 0, 0, 0, -1, 0, 0, 0, 1)}) {
    const glm::dvec3 middle(center);
    const Lattice lattice =
        lattice_from(kSize, [&](glm::dvec3 p) { return middle + turn * (p - middle) - p; });
    for (const ResampleMethod method : kResampleMethods) {
      const auto out = resampled(volume, lattice, Cuts(kSize), method);
      Faults wrong;
      std::int64_t shown = 0;
      for_each_voxel(kSize, [&](VoxelIndex v) {
        const VoxelIndex from(glm::round(middle + glm::transpose(turn) * (glm::dvec3(v) - middle)));
        if (!contains(kSize, from)) {
          if (out.volume.value_at(v) != kBackground) wrong.add(text(v), ": not background");
          return;
        }
        ++shown;
        const double value = out.volume.value_at(v);
        if (is_smoothed(method)) {
          if (!(value >= 0.0 && value <= 1.0)) wrong.add(text(v), ": ", value);
        } else if (!(std::abs(value - volume.value_at(from)) <= 1e-5)) {
          wrong.add(text(v), ": ", value, " not ", volume.value_at(from));
        }
      });
      EXPECT_EQ(wrong.count(), 0) << name_of(method) << ": " << wrong.first();
      EXPECT_GT(shown, 20'000);
    }
  }
}

TEST(ClosedForms, AtRestEveryPointIsItsOwn) {
  const Resampler resampler(random_values(), Lattice(kSize), Cuts(kSize), ResampleMethod::linear,
                            kBackground);
  Chance chance(5);
  for (int i = 0; i < 200; ++i) {
    const glm::dvec3 point =
        0.5 * glm::dvec3(kSize - 1) + 0.5 * glm::dvec3(kSize) * chance.vector(1);
    const auto rest = resampler.rest_position(point);
    ASSERT_TRUE(rest.has_value()) << text(point);
    EXPECT_EQ(*rest, point);
  }
}

class ThereAndBack : public ::testing::TestWithParam<std::tuple<Shape, unsigned>> {};

// Where a point has got to and what lies there: the point, wherever nothing folds.
TEST_P(ThereAndBack, IsWhereItStarted) {
  const auto [shape, seed] = GetParam();
  const RandomScene scene = random_scene(shape, seed);
  const Volume volume = numbered(scene.size, scene.spacing_mm);
  const Resampler resampler(volume, scene.lattice, Cuts(scene.size), ResampleMethod::linear,
                            kBackground);
  Chance chance(seed);
  Faults lost;
  Faults off;
  int tried = 0;
  for (int i = 0; i < 2000; ++i) {
    // Half a voxel beyond the border is material too; not its very end.
    const glm::dvec3 start = 0.5 * glm::dvec3(scene.size - 1) +
                             (0.5 * glm::dvec3(scene.size) - 1e-3) * chance.vector(1.0);
    const glm::dvec3 now = moved(scene.lattice, start);
    // A point that has left the volume is none that a person can pick.
    const glm::dvec3 last = glm::dvec3(scene.size) - 0.5;
    if (glm::any(glm::lessThan(now, glm::dvec3(-0.5))) || glm::any(glm::greaterThan(now, last))) {
      continue;
    }
    ++tried;
    const auto rest = resampler.rest_position(now);
    if (!rest) {
      lost.add(text(start), " at ", text(now));
    } else if (!(glm::distance(*rest, start) <= 1e-3)) {
      off.add(text(start), " at ", text(now), ": ", text(*rest));
    }
  }
  EXPECT_EQ(lost.count(), 0) << lost.first();
  EXPECT_EQ(off.count(), 0) << off.first();
  EXPECT_GT(tried, 100);
}
INSTANTIATE_TEST_SUITE_P(Scenes, ThereAndBack,
                         ::testing::Combine(::testing::Values(Shape::smooth, Shape::rough,
                                                              Shape::steep),
                                            ::testing::Range(81u, 87u)),
                         name_of_scene);

}  // namespace
}  // namespace maille
