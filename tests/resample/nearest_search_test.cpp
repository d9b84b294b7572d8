// The nearest element of every voxel against all elements, in double precision.
#include "resample/nearest_search.h"

#include <cmath>
#include <cstring>
#include <random>

#include <gtest/gtest.h>

#include "resample/rest_march.h"
#include "tests/resample/scenes.h"

namespace maille {
namespace {

using namespace testing;

struct Scene {
  Size3 size;
  glm::dvec3 spacing_mm;
  glm::dmat3 affine;
  double rough;
  bool searched;  // or cells look for voxels: also to be right
};

class NearestOfEveryVoxel : public ::testing::TestWithParam<int> {};

TEST_P(NearestOfEveryVoxel, IsTheNearestOfAllElements) {
  const Scene scenes[] = {
      {{17, 14, 15}, {1, 1, 1}, glm::dmat3(1.0), 0.05, true},
      {{17, 14, 15}, {1, 1, 1}, glm::dmat3(1.0), 0.0, true},
      {{13, 16, 14}, {1, 0.7, 1.6}, glm::dmat3(0.9, 0.3, 0, -0.3, 0.9, 0, 0, 0.1, 1), 0.06, true},
      {{13, 16, 14}, {1, 0.8, 1.3}, glm::dmat3(1, 0.15, 0, -0.15, 1, 0, 0, 0.1, 1), 0.02, true},
      {{15, 13, 12}, {1, 1, 1}, glm::dmat3(3.8, 0, 0, 0, 1, 0, 0, 0, 1), 0.02, true},
      {{14, 14, 14}, {1, 1, 1}, glm::dmat3(0.4, 0, 0, 0, 0.5, 0, 0, 0, 1), 0.02, true},
      {{14, 14, 14}, {1, 1, 1}, glm::dmat3(0.7, 0, 0, 0, 0.8, 0, 0, 0, 1.2), 0.02, true},
      {{15, 12, 13}, {2, 1, 1}, glm::dmat3(1, 0, 0, 0.8, 1, 0, -0.4, 0.3, 1), 0.03, true},
      {{15, 12, 13}, {1.3, 1, 1}, glm::dmat3(1, 0, 0, 0.3, 1, 0, -0.1, 0, 1), 0.02, true},
      {{9, 1, 12}, {1, 3, 1}, glm::dmat3(1.0), 0.08, true},
      {{12, 13, 14}, {1, 1, 1}, glm::dmat3(1.0), 0.7, false},
  };
  const Scene& scene = scenes[GetParam()];
  std::mt19937 random(static_cast<unsigned>(GetParam()));
  std::uniform_real_distribution<double> off(-scene.rough, scene.rough);
  const Lattice lattice = lattice_from(scene.size, [&](glm::dvec3 at) {
    const glm::dvec3 from = at - 0.5 * glm::dvec3(scene.size);
    return scene.affine * from - from + glm::dvec3(off(random), off(random), off(random)) +
           glm::dvec3(0.25);
  });
  const DeformedVolume deformed(lattice, Cuts(scene.size), scene.spacing_mm);
  const VoxelBox voxels = lattice.grid().box({0, 0, 0});
  auto march = march_through(Sight(deformed, voxels), voxels, {Sight::kAround_voxels});
  EXPECT_EQ(march && NearestSearch::around_voxels(march->injection(), deformed.spacing_mm) <=
                         Sight::kAround_voxels,
            scene.searched);

  const Volume volume = numbered(scene.size, scene.spacing_mm);
  const Resampler resampler(volume, lattice, Cuts(scene.size), ResampleMethod::nearest, -1.0);
  std::vector<std::byte> bytes(kBrickVoxels * sizeof(float));
  const ResampleCounts counts = resampler.resample(0, bytes, false);
  std::vector<glm::vec3> rest(kBrickVoxels);
  resampler.rest_positions(0, rest);
  std::vector<glm::dvec3> now_mm;
  for_each_voxel(scene.size, [&](VoxelIndex v) {
    now_mm.push_back((glm::dvec3(v) + lattice.displacement_voxels(v)) * scene.spacing_mm);
  });
  std::size_t i = 0;
  std::int64_t filled = 0;
  for_each_voxel(scene.size, [&](VoxelIndex v) {
    float value = 0.0f;
    std::memcpy(&value, &bytes[sizeof(float) * i], sizeof value);
    const bool inside = !std::isnan(rest[i].x);
    ++i;
    ASSERT_EQ(inside, value >= 0.0f);
    if (!inside) return;
    ++filled;
    const glm::dvec3 here = glm::dvec3(v) * scene.spacing_mm;
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t e = 0; e < now_mm.size(); ++e) {
      const double distance = glm::distance(now_mm[e], here);
      if (distance < least - 1e-9) {
        least = distance;
        best = e;
      }
    }
    const auto found = static_cast<std::size_t>(value);
    // Floats may take the other of two that are as near.
    EXPECT_TRUE(found == best || glm::distance(now_mm[found], here) < least + 1e-5)
        << "(" << v.x << ", " << v.y << ", " << v.z << "): " << found << ", not " << best;
  });
  EXPECT_EQ(filled, counts.voxels - counts.background_voxels);
  EXPECT_GT(filled, 100);
}
INSTANTIATE_TEST_SUITE_P(Scenes, NearestOfEveryVoxel, ::testing::Range(0, 11));

// Whether or not each is near enough to its cell's corners.
TEST(NearestSearch, SameBitsForAnyWidthOfRegisters) {
  const Size3 size{23, 18, 14};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> off(-0.08, 0.08);
  const Lattice lattice = lattice_from(size, [&](glm::dvec3 at) {
    return glm::dvec3(0.3 * at.y, -0.2 * at.x + 0.1 * at.z, 0) +
           glm::dvec3(off(random), off(random), off(random));
  });
  const DeformedVolume deformed(lattice, Cuts(size), {1, 0.7, 1.9});
  const VoxelBox voxels{{2, -3, 1}, {21, 17, 13}};
  auto march = march_through(Sight(deformed, voxels), voxels, {4});
  ASSERT_TRUE(march);
  const DisplacementTile& tile = march->tile();
  const int width = voxels.size().x;
  for (const std::int64_t points : {std::int64_t{1}, voxel_count(voxels.size())}) {
    NearestSearch widest(tile, march->injection(), deformed.spacing_mm, points);
    NearestSearch narrow(tile, march->injection(), deformed.spacing_mm, points, Registers::narrow);
    RestMarch rows(tile, march->injection(), voxels, CellMap::trilinear);
    const glm::vec3 first(voxels.lo - tile.elements().lo - tile.common_voxels());
    for (int row = 0; row < voxels.size().y * voxels.size().z; ++row) {
      const Float4* const rest = rows.next_row();
      const Float4 now{first.x, first.y + static_cast<float>(row % voxels.size().y),
                       first.z + static_cast<float>(row / voxels.size().y), 0.0f};
      NearestSearch::Found a[kBrickEdge + 1];
      NearestSearch::Found b[kBrickEdge + 1];
      widest.find(now, rest, width, ~0u, a);
      narrow.find(now, rest, width, ~0u, b);
      for (int x = 0; x < width; ++x) {
        for (int c = 0; c < 3; ++c) ASSERT_EQ(a[x].element[c], b[x].element[c]) << "row " << row;
        ASSERT_EQ(a[x].squared_mm, b[x].squared_mm) << "row " << row;
      }
    }
  }
}

TEST(NearestSearch, SaysWhereItWouldHaveToLookTooFar) {
  const Size3 size{12, 12, 12};
  const Lattice lattice =
      lattice_from(size, [](glm::dvec3 at) { return glm::dvec3(29.0 * at.x, 0, 0); });
  DisplacementTile tile;
  tile.fill(lattice, {VoxelIndex(0), size});
  EXPECT_GE(NearestSearch::around_voxels(tile.injection(false), glm::vec3(1)), 15)
      << "cells of 30 voxels";
}

}  // namespace
}  // namespace maille
