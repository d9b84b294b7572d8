#include "references/paper_values.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "references/paper_walk.h"
#include "tests/measure/deformed_scenes.h"

namespace maille {
namespace {

using namespace testing;

// On a linear ramp tetrahedra of an affine map are exact, whichever of them holds the voxel.
TEST(PaperValues, BarycentricIsExactOnAffineRamps) {
  const Size3 size{24, 20, 18};
  const glm::dvec3 center{12, 10, 9};
  const std::vector<double> values = ramp(size);
  for (const glm::dmat3& map :
       {glm::dmat3(1), glm::dmat3(1.5, 0, 0, 0, 0.75, 0, 0, 0, 1.3),
        glm::dmat3(1, 0, 0.15, 0.3, 1, 0.1, -0.2, 0.25, 1), glm::dmat3(0, 1, 0, -1, 0, 0, 0, 0, 1),
        glm::dmat3(4, 0, 0, 0, 0.25, 0, 0, 0, 1)}) {
    const DeformedElements elements = deformed(size, affine(map, center), {1, 0.8, 2});
    const glm::dmat3 rest_from_now = glm::inverse(map);
    const auto walked = paper_walk(elements, VoxelIndex(0), size);
    std::int64_t inside = 0;
    for (std::size_t i = 0; i < walked.size(); ++i) {
      const glm::dvec3 point(voxel_of(i, size));
      const glm::dvec3 rest = center + rest_from_now * (point - center);
      if (glm::any(glm::lessThan(rest, glm::dvec3(0.01)))) continue;
      if (glm::any(glm::greaterThan(rest, glm::dvec3(size) - 1.01))) continue;
      ASSERT_TRUE(walked[i].found());
      const PaperValue value =
          paper_value(elements, values, walked[i].element, point, PaperMethod::barycentric);
      ASSERT_TRUE(value.interpolated) << i;
      ASSERT_NEAR(value.value, 3.0 * rest.x - 2.0 * rest.y + 0.5 * rest.z, 1e-6) << i;
      ++inside;
    }
    EXPECT_GT(inside, 500);
  }
}

TEST(PaperValues, BarycentricSaysWhereNoTetrahedronHoldsThePoint) {
  const Size3 size{5, 6, 7};
  const DeformedElements elements = deformed(size, [](glm::dvec3) { return glm::dvec3(0); });
  const std::vector<double> values = ramp(size);
  const std::size_t corner = element_of({4, 0, 3}, size);
  const PaperValue beyond =
      paper_value(elements, values, corner, {4.4, 0, 3}, PaperMethod::barycentric);
  EXPECT_FALSE(beyond.interpolated);
  EXPECT_EQ(beyond.value, values[corner]);
  const PaperValue within =
      paper_value(elements, values, corner, {3.6, 0.2, 3.1}, PaperMethod::barycentric);
  EXPECT_TRUE(within.interpolated);
  EXPECT_NEAR(within.value, 3.0 * 3.6 - 2.0 * 0.2 + 0.5 * 3.1, 1e-12);
  // A single layer has no volume to hold anything.
  const DeformedElements layer = deformed({5, 6, 1}, [](glm::dvec3) { return glm::dvec3(0); });
  EXPECT_FALSE(paper_value(layer, values, 7, {2.2, 1.1, 0}, PaperMethod::barycentric).interpolated);
}

TEST(PaperValues, NearestIsTheElementsOwn) {
  const Size3 size{5, 6, 7};
  const DeformedElements elements = deformed(size, smooth_waves(1, 0.3));
  const std::vector<double> values = ramp(size);
  for (const std::size_t i : {0u, 77u, 209u}) {
    EXPECT_EQ(paper_value(elements, values, i, {2, 3, 4}, PaperMethod::nearest).value, values[i]);
  }
}

TEST(PaperValues, RbfIsTheWeightedMeanOfANeighbourhood) {
  // Two elements, on paper: 0.3 and 1.2 voxels away, in voxels whatever a voxel measures.
  const DeformedElements pair =
      deformed({2, 1, 1}, [](glm::dvec3 p) { return glm::dvec3(0.5 * p.x, 0, 0); }, {3, 0.5, 1});
  const double near = std::exp(-0.3 * 0.3 / (1.4 * 1.4));
  const double far = std::exp(-1.2 * 1.2 / (1.4 * 1.4));
  EXPECT_NEAR(paper_value(pair, std::vector{10.0, 20.0}, 0, {0.3, 0, 0}, PaperMethod::rbf).value,
              (10 * near + 20 * far) / (near + far), 1e-12);
  // So far apart that each weight by itself would be 0.
  const DeformedElements torn =
      deformed({2, 1, 1}, [](glm::dvec3 p) { return glm::dvec3(999 * p.x, 0, 0); });
  const std::vector<double> two{10.0, 20.0};
  EXPECT_EQ(paper_value(torn, two, 0, {500, 0, 0}, PaperMethod::rbf).value, 15.0);
  EXPECT_EQ(paper_value(torn, two, 0, {400, 0, 0}, PaperMethod::rbf).value, 10.0);
  // At rest all weights around an element are even.
  const Size3 size{6, 7, 8};
  const DeformedElements rest = deformed(size, [](glm::dvec3) { return glm::dvec3(0); });
  const std::size_t inner = element_of({2, 3, 4}, size);
  EXPECT_NEAR(paper_value(rest, ramp(size), inner, {2, 3, 4}, PaperMethod::rbf).value,
              ramp(size)[inner], 1e-12);
  // No further than the 26: a value two voxels away has no weight.
  std::vector<double> values(rest.count(), 1.0);
  values[element_of({4, 3, 4}, size)] = 1e9;
  EXPECT_NEAR(paper_value(rest, values, inner, {2, 3, 4}, PaperMethod::rbf).value, 1.0, 1e-12);
}

}  // namespace
}  // namespace maille
