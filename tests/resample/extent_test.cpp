// What has been pulled out of the volume, and where it is seen and saved.
#include <cmath>

#include <gtest/gtest.h>

#include "references/deformed_elements.h"
#include "references/nearest_brute_force.h"
#include "tests/resample/resampled.h"

namespace maille {
namespace {

using namespace testing;

const Size3 kSize{40, 37, 34};
const VoxelBox kOwn{VoxelIndex(0), kSize};

Volume grown(const Volume& volume, const Lattice& lattice, ResampleMethod method,
             ResampleCounts& counts) {
  const Resampler resampler(volume, lattice, Cuts(volume.size()), method, kBackground);
  WorkerPool pool(2);
  return resample_volume(resampler, resampler.extent(), pool, counts);
}

// A bump on one face, that reaches 12.4 voxels out of the volume.
glm::dvec3 bump(glm::dvec3 p) {
  const double away = glm::length((p - glm::dvec3(39, 18, 17)) / glm::dvec3(20, 10, 10));
  return glm::dvec3(12.4, -1.3, 0.8) * std::max(0.0, 1.0 - away);
}

TEST(Extent, IsTheVolumesOwnWhereNothingHasLeftIt) {
  const Volume volume = numbered(kSize);
  const Lattice inside = lattice_from(kSize, [](glm::dvec3 p) {
    return glm::dvec3(3, 2, 1) * std::max(0.0, 1.0 - glm::length(p - glm::dvec3(20, 18, 17)) / 10);
  });
  for (const Lattice& lattice : {Lattice(kSize), inside}) {
    const Resampler resampler(volume, lattice, Cuts(kSize), ResampleMethod::linear, kBackground);
    EXPECT_EQ(resampler.extent(), kOwn);
  }
}

TEST(Extent, HoldsAVolumeThatMovedAsAWhole) {
  const Volume volume = numbered(kSize, {1, 0.5, 2});
  for (const glm::ivec3 shift : {glm::ivec3(5, -3, 0), glm::ivec3(-70, 0, 33)}) {
    const Lattice lattice = lattice_from(kSize, [&](glm::dvec3) { return glm::dvec3(shift); });
    for (const ResampleMethod method :
         {ResampleMethod::nearest, ResampleMethod::linear, ResampleMethod::barycentric}) {
      ResampleCounts counts;
      const Volume out = grown(volume, lattice, method, counts);
      const VoxelIndex lo = glm::min(VoxelIndex(0), VoxelIndex(shift));
      ASSERT_EQ(out.size(), glm::max(kSize, kSize + shift) - lo);
      EXPECT_EQ(out.world_from_voxel()[3],
                volume.world_from_voxel() * glm::dvec4(glm::dvec3(lo), 1));
      EXPECT_EQ(counts.unfilled_voxels, 0);
      std::int64_t shown = 0;
      for_each_voxel(out.size(), [&](VoxelIndex v) {
        const VoxelIndex from = v + lo - shift;
        const double expected = contains(kSize, from) ? volume.value_at(from) : kBackground;
        ASSERT_EQ(out.value_at(v), expected) << name_of(method);
        shown += expected != kBackground;
      });
      EXPECT_EQ(shown, voxel_count(kSize));
    }
  }
}

// Inside of the volume it shows what it shows without; outside the nearest of all elements, and of
// a ramp the value of where it was at rest.
TEST(Extent, ShowsABumpThatLeftTheVolume) {
  const auto ramp = [](glm::dvec3 p) { return 100 + 3 * p.x - 2 * p.y + 0.5 * p.z; };
  const Volume ramps = volume_from<float>(kSize, VoxelType::float32, glm::dvec3(1),
                                          [&](VoxelIndex v) { return ramp(v); });
  const Lattice lattice = lattice_from(kSize, bump);
  std::vector<glm::dvec3> u;
  for_each_voxel(kSize, [&](VoxelIndex v) { u.push_back(lattice.displacement_voxels(v)); });
  const DeformedElements elements(kSize, glm::dvec3(1), u);
  const NearestBruteForce brute_force(elements);
  const Volume numbers = numbered(kSize);
  for (const ResampleMethod method : kResampleMethods) {
    const Volume& volume = method == ResampleMethod::nearest ? numbers : ramps;
    const Resampler resampler(volume, lattice, Cuts(kSize), method, kBackground);
    const VoxelBox extent = resampler.extent();
    EXPECT_EQ(extent.lo, VoxelIndex(0));
    // The furthest element lies at 51.4, and material ends half a voxel beyond it.
    EXPECT_EQ(extent.hi, VoxelIndex(52, kSize.y, kSize.z));
    ResampleCounts counts;
    WorkerPool pool(2);
    const Volume out = resample_volume(resampler, extent, pool, counts);
    const Volume own = resampled(volume, lattice, Cuts(kSize), method).volume;
    EXPECT_EQ(counts.voxels, voxel_count(extent.size()));
    EXPECT_EQ(counts.unfilled_voxels, 0);
    std::int64_t beyond = 0;
    for_each_voxel(extent.size(), [&](VoxelIndex v) {
      const double value = out.value_at(v);
      if (contains(kSize, v)) {
        // The same but for where a march began.
        const double allowed = method == ResampleMethod::nearest ? 0.0 : 5e-3;
        ASSERT_NEAR(value, own.value_at(v), allowed) << name_of(method);
        return;
      }
      const auto rest = resampler.rest_position(glm::dvec3(v));
      ASSERT_EQ(value == kBackground, !rest.has_value()) << name_of(method);
      if (!rest) return;
      ++beyond;
      if (method == ResampleMethod::nearest) {
        const auto nearest = brute_force.nearest_to(glm::dvec3(v));
        ASSERT_EQ(value, static_cast<double>(nearest.element));
      } else if (method != ResampleMethod::rbf) {
        ASSERT_NEAR(value, ramp(glm::clamp(*rest, glm::dvec3(0), glm::dvec3(kSize - 1))), 0.01);
      }
    });
    EXPECT_GT(beyond, 500);
  }
}

}  // namespace
}  // namespace maille
