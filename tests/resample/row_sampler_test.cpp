// The row sampler against trilinear interpolation in double precision.
#include "resample/row_sampler.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "resample/claims.h"
#include "tests/resample/resampled.h"
#include "tests/resample/row_sampler_scenes.h"

namespace maille {

testing::SampledBits testing::sampled_by_loaders_choice(unsigned seed) {
  return sampled_by<RowSampler>(seed);
}

namespace {

using namespace testing;

TEST(RowSampler, MixesAsDoublesDo) {
  const Size3 size{40, 9, 12};
  std::mt19937 random(3);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const Volume volume = volume_from<float>(size, VoxelType::float32, glm::dvec3(1),
                                           [&](VoxelIndex) { return between(-1.0, 1.0); });
  const VoxelBox elements{{2, 0, 3}, {31, 9, 12}};
  RowSampler sampler(size, elements);
  int among = 0;
  for (int row = 0; row < 500; ++row) {
    Float4 rest[kBrickEdge];
    for (Float4& at : rest) {
      for (int c = 0; c < 3; ++c) {
        at[c] = static_cast<float>(between(-1.0, elements.size()[c] + 0.5));
      }
    }
    sampler.sample(volume.voxels<float>(), CellMap::trilinear, rest, kBrickEdge);
    for (int x = 0; x < kBrickEdge; ++x) {
      const glm::dvec3 at = glm::dvec3(rest[x][0], rest[x][1], rest[x][2]);
      // Half a voxel beyond where the elements end with the volume: along y, and above along z.
      const glm::dvec3 least(0, -0.5, 0);
      const glm::dvec3 most(28, 8.5, 8.5);
      const glm::dvec3 within = glm::min(at - least, most - at);
      const double depth = std::min({within.x, within.y, within.z});
      if (std::abs(depth) < 2 * kInside_cells) continue;
      const bool inside = depth > 0.0;
      EXPECT_EQ(sampler.is_among(x), inside) << at.x << ' ' << at.y << ' ' << at.z;
      if (!inside) continue;
      ++among;
      EXPECT_NEAR(sampler.value(x), trilinear(volume, at + glm::dvec3(elements.lo)), 2e-5);
    }
  }
  EXPECT_GT(among, 5000);
}

}  // namespace
}  // namespace maille
