// Rows of rest positions, and what the loops over them make of these, to compare versions compiled
// for several vector widths.
#pragma once

#include <bit>
#include <cstdint>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include "resample/deformed_cell.h"
#include "volume/brick.h"

namespace maille::testing {

// Bits of all that is said of all rows of a scene.
using SampledBits = std::vector<std::uint32_t>;

// By the versions that the loader chose.
SampledBits sampled_by_loaders_choice(unsigned seed);

inline std::uint32_t bits_of(float value) {
  // Which NaN comes of several is the machine's affair.
  return std::bit_cast<std::uint32_t>(value != value ? std::numeric_limits<float>::quiet_NaN()
                                                     : value);
}

template <class RowSampler>
SampledBits sampled_by(unsigned seed) {
  constexpr Size3 kSize{21, 13, 11};
  std::mt19937 random(seed);
  const auto between = [&](double low, double high) {
    return static_cast<float>(std::uniform_real_distribution<double>(low, high)(random));
  };
  std::vector<float> voxels;
  for (std::int64_t i = 0; i < voxel_count(kSize); ++i) {
    const unsigned kind = random() % 40;
    voxels.push_back(kind == 0   ? std::numeric_limits<float>::infinity()
                     : kind == 1 ? std::numeric_limits<float>::quiet_NaN()
                                 : between(-1e3, 1e3));
  }
  const bool all = seed % 2 == 0;
  const VoxelBox elements = all ? VoxelBox{VoxelIndex(0), kSize} : VoxelBox{{3, 2, 0}, {17, 13, 9}};
  RowSampler sampler(kSize, elements);
  SampledBits bits;
  for (int row = 0; row < 200; ++row) {
    const int count = 1 + static_cast<int>(random() % kBrickEdge);
    Float4 rest[kBrickEdge];
    for (int x = 0; x < count; ++x) {
      // Beyond the elements too, on them, and so near that they count as on them.
      for (int c = 0; c < 3; ++c) {
        rest[x][c] = between(-1.0, elements.size()[c] + 0.5);
        const unsigned kind = random() % 4;
        if (kind < 2) rest[x][c] = static_cast<float>(static_cast<int>(rest[x][c]));
        if (kind == 1) rest[x][c] += between(-2e-5, 2e-5);
      }
      rest[x][3] = 0.0f;
    }
    for (const CellMap map : {CellMap::trilinear, CellMap::tetrahedra}) {
      sampler.sample(std::span<const float>(voxels), map, rest, count);
      for (int x = 0; x < count; ++x) {
        bits.push_back(bits_of(sampler.value(x)));
        bits.push_back(sampler.is_among(x));
        for (int c = 0; c < 3; ++c) bits.push_back(bits_of(sampler.position(x)[c]));
      }
    }
  }
  return bits;
}

}  // namespace maille::testing
