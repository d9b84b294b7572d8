// Analytic deformations of an analytic volume: what `linear` shows is as near to it as
// interpolation in the volume at rest is, and nothing is left out.
#include <algorithm>
#include <cmath>
#include <ostream>
#include <string>

#include <gtest/gtest.h>

#include "tests/measure/deformed_scenes.h"
#include "tests/resample/faults.h"
#include "tests/resample/resampled.h"

namespace maille {
namespace {

using namespace testing;

constexpr Size3 kSize{48, 52, 50};
const glm::dvec3 kMiddle(24, 26, 25);

// No wave shorter than 9 voxels; within -1 and 1.
double analytic_value(glm::dvec3 p) {
  return 0.4 * std::sin(glm::dot(p, glm::dvec3(0.5, 0.3, -0.2)) + 1.0) +
         0.3 * std::sin(glm::dot(p, glm::dvec3(-0.2, 0.55, 0.3)) + 2.0) +
         0.3 * std::sin(glm::dot(p, glm::dvec3(0.3, -0.1, 0.6)));
}

struct Deformation {
  const char* name;
  Field u;
};
void PrintTo(const Deformation& deformation, std::ostream* out) { *out << deformation.name; }

// Slopes `most` in the middle and `least` far from it along an axis.
double stretched_to(double s, double least, double most) {
  constexpr double kWidth_voxels = 14.0;
  return least * s + (most - least) * kWidth_voxels * std::tanh(s / kWidth_voxels);
}
double wave(double s, double length_voxels, double steepest) {
  const double k = 2.0 * kPi / length_voxels;
  return steepest / k * std::sin(k * s);
}
const Deformation kDeformations[] = {
    {"mild", smooth_waves(7, 0.2)},
    {"stretched 4 times", affine(glm::dmat3(4, 0, 0, 0, 1, 0, 0, 0, 1), kMiddle)},
    {"stretched 4 times along all", affine(glm::dmat3(4.0), kMiddle)},
    {"stretched 4 times in the middle",
     [](glm::dvec3 p) {
       const double s = p.x - kMiddle.x;
       return glm::dvec3(stretched_to(s, 0.25, 4.0) - s, 0, 0);
     }},
    {"squeezed to a quarter", affine(glm::dmat3(0.25, 0, 0, 0, 1, 0, 0, 0, 1), kMiddle + 0.3)},
    {"squeezed to a quarter along all", affine(glm::dmat3(0.25), kMiddle + 0.3)},
    {"squeezed to a quarter in the middle",
     [](glm::dvec3 p) {
       const double s = p.y - kMiddle.y;
       return glm::dvec3(0, stretched_to(s, 1.5, 0.25) - s, 0);
     }},
    {"sheared", affine(glm::dmat3(1, 0, 0, 0.9, 1, 0, -0.5, 0.4, 1), kMiddle)},
    {"sheared back and forth",
     [](glm::dvec3 p) { return glm::dvec3(wave(p.y, 50.0, 0.8), 0, wave(p.x, 60.0, 0.7)); }},
    {"nearly folding",
     [](glm::dvec3 p) { return glm::dvec3(wave(p.x, 48.0, 0.95), wave(p.y, 52.0, 0.5), 0); }},
};

// The X with X + u(X) = x, from near it on.
glm::dvec3 inverse(const Field& u, glm::dvec3 x, glm::dvec3 start) {
  glm::dvec3 rest = start;
  for (int i = 0; i < 60; ++i) {
    constexpr double kStep = 1e-5;
    glm::dmat3 jacobian(1.0);
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 step(0);
      step[axis] = kStep;
      jacobian[axis] += (u(rest + step) - u(rest - step)) / (2 * kStep);
    }
    const glm::dvec3 by = glm::inverse(jacobian) * (x - rest - u(rest));
    rest += by;
    if (glm::length(by) < 1e-12) break;
  }
  return rest;
}

class Analytic : public ::testing::TestWithParam<Deformation> {};

TEST_P(Analytic, LinearIsAsNearAsInterpolationAtRest) {
  const Field& u = GetParam().u;
  const Lattice lattice = lattice_from(kSize, u);
  const Volume volume =
      volume_from<float>(kSize, VoxelType::float32, glm::dvec3(1),
                         [](VoxelIndex v) { return analytic_value(glm::dvec3(v)); });
  const auto out = resampled(volume, lattice, Cuts(kSize), ResampleMethod::linear, 2);
  EXPECT_EQ(out.counts.unfilled_voxels, 0);
  const std::vector<glm::vec3> rest = rest_positions(volume, lattice, Cuts(kSize));
  double sum = 0.0;
  double sum_at_rest = 0.0;
  std::int64_t count = 0;
  Faults missing;
  Faults untold;
  std::size_t i = 0;
  for_each_voxel(kSize, [&](VoxelIndex v) {
    const glm::dvec3 at(rest[i++]);
    const glm::dvec3 x(v);
    const bool shown = out.volume.value_at(v) != kBackground;
    // From where it starts is no matter: there is one answer, and whether it is one is looked at.
    const glm::dvec3 truth = inverse(u, x, shown ? at : x);
    if (!(glm::distance(truth + u(truth), x) < 1e-9)) {
      // Waves go on beyond the volume: far outside of it there need be no answer.
      if (shown) untold.add(v.x, ' ', v.y, ' ', v.z);
      return;
    }
    const glm::dvec3 within = glm::min(truth, glm::dvec3(kSize - 1) - truth);
    const double depth = std::min({within.x, within.y, within.z});
    if (!shown) {
      if (depth > 0.0) missing.add(v.x, ' ', v.y, ' ', v.z);
      return;
    }
    if (depth < 0.0) return;
    ++count;
    const double expected = analytic_value(truth);
    const double error = out.volume.value_at(v) - expected;
    const double error_at_rest = trilinear(volume, truth) - expected;
    sum += error * error;
    sum_at_rest += error_at_rest * error_at_rest;
  });
  EXPECT_EQ(missing.count(), 0) << missing.first();
  EXPECT_EQ(untold.count(), 0) << untold.first();
  EXPECT_GT(count, 1000);
  const double rms = std::sqrt(sum / static_cast<double>(count));
  const double rms_at_rest = std::sqrt(sum_at_rest / static_cast<double>(count));
  EXPECT_GT(rms_at_rest, 1e-3) << "nothing to compare with";
  EXPECT_LE(rms, 1.05 * rms_at_rest);
  RecordProperty("rms_times_1e6", static_cast<int>(1e6 * rms));
  RecordProperty("rms_at_rest_times_1e6", static_cast<int>(1e6 * rms_at_rest));
}
std::string name_of_deformation(const ::testing::TestParamInfo<Deformation>& scene) {
  std::string name = scene.param.name;
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(Deformations, Analytic, ::testing::ValuesIn(kDeformations),
                         name_of_deformation);

}  // namespace
}  // namespace maille
