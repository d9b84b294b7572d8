// Deformed elements from formulas, for the references of resampling.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "references/deformed_elements.h"

namespace maille::testing {

using Field = std::function<glm::dvec3(glm::dvec3)>;  // displacement (voxels) of a rest position

inline constexpr double kPi = 3.14159265358979;

inline DeformedElements deformed(Size3 size, const Field& u,
                                 glm::dvec3 spacing_mm = glm::dvec3(1)) {
  std::vector<glm::dvec3> u_voxels;
  const auto count = static_cast<std::size_t>(voxel_count(size));
  for (std::size_t i = 0; i < count; ++i) u_voxels.push_back(u(glm::dvec3(voxel_of(i, size))));
  return DeformedElements(size, spacing_mm, std::move(u_voxels));
}

// A few long waves in every direction, no steeper than `steepest` along any axis in any component.
inline Field smooth_waves(unsigned seed, double steepest) {
  struct Wave {
    glm::dvec3 direction;  // radians a voxel
    glm::dvec3 by;
    double phase;
  };
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> signed_unit(-1.0, 1.0);
  const auto vector = [&] {
    const double x = signed_unit(random);
    const double y = signed_unit(random);
    return glm::dvec3(x, y, signed_unit(random));
  };
  std::vector<Wave> waves;
  glm::dmat3 slopes(0.0);
  for (int i = 0; i < 5; ++i) {
    const glm::dvec3 direction = 0.3 * vector();
    const glm::dvec3 by = vector();
    waves.push_back({direction, by, kPi * signed_unit(random)});
    slopes += glm::outerProduct(glm::abs(by), glm::abs(direction));
  }
  double most = 0.0;
  for (int a = 0; a < 3; ++a) {
    for (int c = 0; c < 3; ++c) most = std::max(most, slopes[a][c]);
  }
  return [waves, scale = steepest / most](glm::dvec3 p) {
    glm::dvec3 u(0.0);
    for (const Wave& wave : waves)
      u += wave.by * std::sin(glm::dot(wave.direction, p) + wave.phase);
    return scale * u;
  };
}

inline Field affine(const glm::dmat3& map, glm::dvec3 center) {
  return [=](glm::dvec3 p) { return center + map * (p - center) - p; };
}

// Along x: the middle fifth of 0 .. last stretched 4 times, the rest squeezed to a quarter of its
// length, the ends still. No folds.
inline Field stretched_and_squeezed(double last) {
  return [=](glm::dvec3 p) {
    const double s = p.x / last;
    const double x = s < 0.4 ? 0.25 * s : s < 0.6 ? 0.1 + 4.0 * (s - 0.4) : 0.9 + 0.25 * (s - 0.6);
    return glm::dvec3(last * x - p.x, 0, 0);
  };
}

// Along x there and back: x(X) turns at two places in 24 voxels.
inline Field folded() {
  return [](glm::dvec3 p) { return glm::dvec3(6.0 * std::sin(p.x * 2.0 * kPi / 24.0), 0, 0); };
}

// A value of each element, linear in its rest position.
inline std::vector<double> ramp(Size3 size) {
  std::vector<double> values;
  for (std::size_t i = 0; i < static_cast<std::size_t>(voxel_count(size)); ++i) {
    const VoxelIndex v = voxel_of(i, size);
    values.push_back(3.0 * v.x - 2.0 * v.y + 0.5 * v.z);
  }
  return values;
}

}  // namespace maille::testing
