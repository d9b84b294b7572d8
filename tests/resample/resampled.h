// What the product makes of a deformed volume, whole.
#pragma once

#include <algorithm>
#include <cstring>
#include <vector>

#include "tests/resample/scenes.h"

namespace maille::testing {

inline constexpr double kBackground = -1000.0;

// Whether a method shows an element that lies on a voxel mixed with those around it.
inline bool is_smoothed(ResampleMethod method) { return method == ResampleMethod::rbf; }

struct Resampled {
  Volume volume;
  ResampleCounts counts;
};
inline Resampled resampled(const Volume& volume, const Lattice& lattice, const Cuts& cuts,
                           ResampleMethod method, int threads = 1) {
  WorkerPool pool(threads);
  ResampleCounts counts;
  const Resampler resampler(volume, lattice, cuts, method, kBackground);
  Volume out = resample_volume(resampler, {VoxelIndex(0), volume.size()}, pool, counts);
  return {std::move(out), counts};
}

inline bool same_bytes(const Volume& a, const Volume& b) {
  return a.bytes().size() == b.bytes().size() &&
         std::memcmp(a.bytes().data(), b.bytes().data(), a.bytes().size()) == 0;
}

// Of every voxel, x fastest. NaN where nothing is.
inline std::vector<glm::vec3> rest_positions(const Volume& volume, const Lattice& lattice,
                                             const Cuts& cuts,
                                             ResampleMethod method = ResampleMethod::linear) {
  const Resampler resampler(volume, lattice, cuts, method, kBackground);
  const BrickGrid& grid = lattice.grid();
  std::vector<glm::vec3> all(static_cast<std::size_t>(voxel_count(volume.size())));
  std::vector<glm::vec3> brick(kBrickVoxels);
  for (std::int64_t b = 0; b < grid.count(); ++b) {
    resampler.rest_positions(b, brick);
    const VoxelBox box = grid.box(grid.brick(b));
    auto from = brick.begin();
    for_each_voxel({1, box.size().y, box.size().z}, [&](VoxelIndex row) {
      const std::int64_t at = linear_index(box.lo + row, volume.size());
      std::copy_n(from, box.size().x, all.begin() + at);
      from += box.size().x;
    });
  }
  return all;
}

// Of the volume at rest, in double precision; beyond its border as at the border.
inline double trilinear(const Volume& volume, glm::dvec3 rest) {
  const Size3 size = volume.size();
  const glm::dvec3 inside = glm::clamp(rest, glm::dvec3(0), glm::dvec3(size - 1));
  const VoxelIndex base =
      glm::max(glm::min(VoxelIndex(glm::floor(inside)), size - 2), VoxelIndex(0));
  const glm::dvec3 t = inside - glm::dvec3(base);
  double sum = 0.0;
  for (unsigned k = 0; k < 8; ++k) {
    const VoxelIndex corner(k & 1u, k >> 1 & 1u, k >> 2);
    const glm::dvec3 along = glm::mix(1.0 - t, t, glm::dvec3(corner));
    const double weight = along.x * along.y * along.z;
    if (weight != 0.0) sum += weight * volume.value_at(glm::min(base + corner, size - 1));
  }
  return sum;
}

}  // namespace maille::testing
