// The inner loops of relaxation against plain loops in double precision.
#include "deform/spring_rows.h"

#include <gtest/gtest.h>

#include "references/dense_problem.h"
#include "tests/deform/spring_row_scenes.h"

namespace maille {
namespace {

using testing::for_each_row_of;
using testing::RowScene;
using testing::workers;

class SpringRows : public ::testing::TestWithParam<int> {};

TEST_P(SpringRows, ForcesAreThoseOfEachSpring) {
  const RowScene scene(GetParam());
  SpringProblem twin = scene.twin();
  const DenseSprings springs(twin, workers());
  const DisplacementField u = mm_of(twin.start_voxels, twin.spacing_mm);
  std::int64_t checked = 0;
  for_each_row_of(scene.box(), 1, [&](const SpringRun& run) {
    if (run.kind == RowKind::held) return;
    RunVectors out;
    spring_forces(scene.box(), run, out);
    for (int x = 0; x < run.count; ++x) {
      if (!scene.box().is_free(run.first + x)) continue;
      const std::size_t i = scene.element_of_volume(run.first + x);
      const glm::dvec3 expected = -springs.spring_gradient_of(i, u);
      const glm::dvec3 force(out.x[x], out.y[x], out.z[x]);
      // Lengths of a few mm, each known to a few parts in 10^7.
      ASSERT_LT(glm::length(force - expected), 1e-5 * springs.stiffness_sum(i));
      ++checked;
    }
  });
  EXPECT_EQ(checked, scene.box().free_elements());
}

TEST_P(SpringRows, SumsAreThoseOfEachSpring) {
  const RowScene scene(GetParam());
  SpringProblem twin = scene.twin();
  DenseSprings springs(twin, workers());
  const DisplacementField u = mm_of(twin.start_voxels, twin.spacing_mm);
  const DisplacementField d = scene.direction_of_volume();
  double energy = 0.0;
  double bound = 0.0;
  for (std::size_t i = 0; i < u.size(); ++i) {
    springs.for_each_spring_of(i, [&](std::size_t j, const DenseSprings::SpringView& s) {
      if (j < i || (springs.held(i) && springs.held(j))) return;
      const glm::dvec3 du = u[j] - u[i];
      const double stretch = glm::length(s.rest_mm + du) - s.length_mm;
      const glm::dvec3 off = du - s.kept_mm;
      energy +=
          0.5 * s.stiffness * ((1.0 - s.blend) * stretch * stretch + s.blend * glm::dot(off, off));
      bound += s.stiffness * glm::dot(d[j] - d[i], d[j] - d[i]);
    });
  }
  springs.linearise(u, false);
  DisplacementField hd;
  springs.apply(d, hd);
  double curvature = 0.0;
  for (std::size_t i = 0; i < d.size(); ++i) curvature += glm::dot(d[i], hd[i]);

  SpringSums sums;
  double bound_of_rows = 0.0;
  for_each_row_of(scene.box(), 0, [&](const SpringRun& run) {
    const SpringSums part = spring_sums(scene.box(), run, scene.way());
    sums.energy += part.energy;
    sums.curvature += part.curvature;
    bound_of_rows += spring_bound(scene.box(), run, scene.way());
  });
  EXPECT_NEAR(sums.energy, energy, 2e-6 * energy);
  EXPECT_NEAR(bound_of_rows, bound, 2e-6 * bound);
  EXPECT_NEAR(sums.curvature, curvature, 1e-5 * bound);
  EXPECT_LE(sums.curvature, bound_of_rows);
}

TEST_P(SpringRows, LaplacianIsThatOfEachSpring) {
  const RowScene scene(GetParam());
  SpringProblem twin = scene.twin();
  const DenseSprings springs(twin, workers());
  const DisplacementField w = scene.direction_of_volume();
  for_each_row_of(scene.box(), 1, [&](const SpringRun& run) {
    if (run.kind == RowKind::held) return;
    std::array<RowsAround, 3> rows;
    const Size3 extent = scene.box().extent();
    for (std::size_t c = 0; c < 3; ++c) {
      for (int r = 0; r < 9; ++r) {
        const std::int64_t step = (std::int64_t{r / 3 - 1} * extent.y + (r % 3 - 1)) * extent.x;
        rows[c].at[static_cast<std::size_t>(r)] = &scene.direction()[c][run.first + step];
      }
    }
    RunVectors out;
    laplacian(scene.box(), run, rows, out);
    for (int x = 0; x < run.count; ++x) {
      if (!scene.box().is_free(run.first + x)) continue;
      const std::size_t i = scene.element_of_volume(run.first + x);
      glm::dvec3 expected(0);
      springs.for_each_spring_of(i, [&](std::size_t j, const DenseSprings::SpringView& s) {
        expected += s.stiffness * (w[i] - w[j]);
      });
      const glm::dvec3 sum(out.x[x], out.y[x], out.z[x]);
      ASSERT_LT(glm::length(sum - expected), 2e-6 * springs.stiffness_sum(i));
    }
  });
}

INSTANTIATE_TEST_SUITE_P(Scenes, SpringRows, ::testing::Range(0, RowScene::kCount));

TEST(DotOfRun, IsThatOfAPlainLoop) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> number(-1, 1);
  for (int count = 0; count <= kLongestRun; ++count) {
    std::vector<float> a;
    std::vector<float> b;
    double expected = 0.0;
    for (int x = 0; x < count; ++x) {
      a.push_back(number(random));
      b.push_back(number(random));
      expected += double{a.back()} * double{b.back()};
    }
    a.resize(kLongestRun, 1e30f);
    b.resize(kLongestRun, 1e30f);
    ASSERT_NEAR(dot_of_run(a.data(), b.data(), count), expected, 1e-13 * (count + 1));
  }
}

}  // namespace
}  // namespace maille
