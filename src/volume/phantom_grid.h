// What the formula volumes share: a box of mm laid over the voxels, partial volume, and noise that
// is the same on every machine.
#pragma once

#include <cstdint>
#include <functional>

#include "core/parallel.h"
#include "core/spaces.h"
#include "volume/solid.h"
#include "volume/volume.h"

namespace maille {

// The box [lowest, highest] mm filled by the volume whatever its size: spacing is the box's extent
// over the number of voxels, sample (0,0,0) half a spacing inside its lowest corner.
struct PhantomGrid {
  PhantomGrid(Size3 voxels, glm::dvec3 lowest, glm::dvec3 highest);

  glm::dvec3 position(glm::dvec3 voxel) const { return origin + spacing * voxel; }
  glm::dmat4 world_from_voxel() const { return axis_aligned(spacing, origin); }
  // Width over which an edge goes from one value to the other, in mm: a mean spacing and a half
  // to each side.
  float edge_width() const;

  Size3 size;
  glm::dvec3 spacing;
  glm::dvec3 origin;
};

// Calls f once for each 8^3 block of the grid, on any worker: f(block, its first voxel, worker).
void for_each_block(
    const PhantomGrid& grid, WorkerPool& pool,
    const std::function<void(const PointBlock& block, VoxelIndex first, int worker)>& f);

// Writes value_of(i) (i: index in the block) for those of the block's voxels that the volume has.
template <class T, class F>
void write_block(const PhantomGrid& grid, VoxelIndex first, T* samples, F&& value_of) {
  constexpr int n = PointBlock::kEdge;
  const glm::ivec3 count = glm::min(grid.size - first, glm::ivec3(n));
  for (int z = 0; z < count.z; ++z) {
    for (int y = 0; y < count.y; ++y) {
      T* row = samples + linear_index(first + VoxelIndex(0, y, z), grid.size);
      for (int x = 0; x < count.x; ++x) {
        row[x] = value_of(static_cast<std::size_t>((z * n + y) * n + x));
      }
    }
  }
}

// 1 well inside (distance negative), 0 well outside, a ramp of edge_width around 0. Straight,
// because between samples of a straight ramp the surface is where the formula has it; one with soft
// ends shows the grid in the shading.
inline float coverage(float distance, float inverse_edge_width) {
  const float t = 0.5f - distance * inverse_edge_width;
  const float clamped = t < 0.0f ? 0.0f : (t > 1.0f ? 1.0f : t);
  return clamped;
}

inline float mix(float a, float b, float t) { return a + (b - a) * t; }

inline std::uint32_t scrambled(std::uint32_t h) {
  h = (h ^ (h >> 16)) * 0x7feb352du;
  h = (h ^ (h >> 15)) * 0x846ca68bu;
  return h ^ (h >> 16);
}

inline std::uint32_t voxel_hash(VoxelIndex v, std::uint64_t seed) {
  const auto u = [](int i) { return static_cast<std::uint32_t>(i); };
  const auto low = static_cast<std::uint32_t>(seed), high = static_cast<std::uint32_t>(seed >> 32);
  return scrambled(u(v.x) * 0x9e3779b1u ^
                   scrambled(u(v.y) * 0x85ebca77u ^
                             scrambled(u(v.z) * 0xc2b2ae3du ^ scrambled(low ^ scrambled(high)))));
}

// About a normal distribution of deviation 1 (four bytes summed), in -3.4 .. 3.4.
inline float noise_of(std::uint32_t hash) {
  const auto sum = (hash & 255u) + (hash >> 8 & 255u) + (hash >> 16 & 255u) + (hash >> 24);
  return (static_cast<float>(sum) - 510.0f) * (1.0f / 148.0f);
}

// Noise of one lattice cell a unit, in 0 .. 1, with continuous slope.
float smooth_noise(glm::vec3 p, std::uint64_t seed);

// The nearest integer, halves up.
inline int rounded(float value) {
  const float up = value + 0.5f;
  const int truncated = static_cast<int>(up);
  return static_cast<float>(truncated) > up ? truncated - 1 : truncated;
}

}  // namespace maille
