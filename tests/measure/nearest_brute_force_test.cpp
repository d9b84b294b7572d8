#include "references/nearest_brute_force.h"

#include <random>
#include <string>

#include <gtest/gtest.h>

#include "tests/measure/deformed_scenes.h"

namespace maille {
namespace {

using namespace testing;

TEST(NearestBruteForce, IsWhatLookingAtEveryElementFinds) {
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    // From smooth to torn to pieces, with one element out of all scale.
    std::uniform_real_distribution<double> move(-0.3 * seed * seed, 0.3 * seed * seed);
    const Size3 size = seed == 6 ? Size3(40, 1, 7) : Size3(9, 11, 8);
    const VoxelIndex far(4, 0, 3);
    const DeformedElements elements = deformed(size,
                                               [&](glm::dvec3 p) {
                                                 if (seed == 5 && VoxelIndex(p) == far)
                                                   return glm::dvec3(1e6, -1e6, 0);
                                                 const double x = move(random);
                                                 const double y = move(random);
                                                 return glm::dvec3(x, y, move(random));
                                               },
                                               {1, 0.8, 2.5});
    const NearestBruteForce nearest(elements);
    std::uniform_real_distribution<double> place_mm(-15.0, 40.0);
    for (int i = 0; i < 500; ++i) {
      const double x = place_mm(random);
      const double y = place_mm(random);
      const glm::dvec3 point_mm(x, y, place_mm(random));
      ElementDistance best = elements.distance(0, point_mm);
      for (std::size_t k = 1; k < elements.count(); ++k) {
        const ElementDistance here = elements.distance(k, point_mm);
        if (here.squared_mm2 < best.squared_mm2) best = here;
      }
      const ElementDistance found = nearest.nearest_to(point_mm);
      ASSERT_EQ(found.element, best.element);
      ASSERT_EQ(found.squared_mm2, best.squared_mm2);
    }
  }
}

// But for the lower borders every voxel lies between eight elements, as far from each.
TEST(NearestBruteForce, TiesGoToTheLowerIndex) {
  const Size3 size{7, 6, 5};
  const DeformedElements elements = deformed(size, [](glm::dvec3) { return glm::dvec3(0.5); });
  const NearestBruteForce nearest(elements);
  for (std::size_t i = 0; i < elements.count(); ++i) {
    const VoxelIndex voxel = voxel_of(i, size);
    const VoxelIndex lower = glm::max(voxel - 1, VoxelIndex(0));
    ASSERT_EQ(nearest.nearest_to(glm::dvec3(voxel)).element, element_of(lower, size));
  }
}

}  // namespace
}  // namespace maille
