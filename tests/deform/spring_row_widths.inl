// One version of the inner loops of relaxation, compiled by hand for one vector width, against the
// one that the loader chose: every bit. A test file a width defines MAILLE_WIDTH, what to call the
// version, and MAILLE_FOR_THIS_WIDTH, then includes this.
#include <bit>
#include <cmath>

#include <gtest/gtest.h>

#include "core/several_widths.h"
#include "deform/cell_rows.h"
#include "deform/spring_rows.h"
#include "tests/deform/spring_row_scenes.h"

#undef MAILLE_FOR_SEVERAL_WIDTHS
#define MAILLE_FOR_SEVERAL_WIDTHS MAILLE_FOR_THIS_WIDTH
#define MAILLE_JOIN_(a, b) a##b
#define MAILLE_JOIN(a, b) MAILLE_JOIN_(a, b)
#define MAILLE_OF_WIDTH(name) MAILLE_JOIN(name, MAILLE_WIDTH)
#define spring_forces MAILLE_OF_WIDTH(spring_forces)
#define spring_sums MAILLE_OF_WIDTH(spring_sums)
#define dot_of_run MAILLE_OF_WIDTH(dot_of_run)
#define laplacian MAILLE_OF_WIDTH(laplacian)
#define stiffnesses MAILLE_OF_WIDTH(stiffnesses)
#define spring_bound MAILLE_OF_WIDTH(spring_bound)
#define largest_square MAILLE_OF_WIDTH(largest_square)
#define measure_cells MAILLE_OF_WIDTH(measure_cells)
namespace maille {
void stiffnesses(const SpringBox& box, const SpringRun& run, int spring, float* k);
}  // namespace maille
// The sources themselves: there is no other way to a version that the loader would not choose.
#include "deform/cell_rows.cpp"
#include "deform/spring_rows.cpp"
#undef spring_forces
#undef spring_sums
#undef dot_of_run
#undef laplacian
#undef stiffnesses
#undef spring_bound
#undef largest_square
#undef measure_cells

namespace maille {
namespace {

bool same_bits(const float* a, const float* b, int count) {
  for (int x = 0; x < count; ++x) {
    if (std::bit_cast<std::uint32_t>(a[x]) != std::bit_cast<std::uint32_t>(b[x])) return false;
  }
  return true;
}
bool same_bits(const RunVectors& a, const RunVectors& b, int count) {
  return same_bits(a.x, b.x, count) && same_bits(a.y, b.y, count) && same_bits(a.z, b.z, count);
}

TEST(MAILLE_OF_WIDTH(SpringRowsOf), SameBitsAsTheLoadersChoice) {
  if (!MAILLE_HAS_THIS_WIDTH) GTEST_SKIP() << "not on this machine";
  for (int number = 0; number < testing::RowScene::kCount; ++number) {
    SCOPED_TRACE(number);
    const testing::RowScene scene(number);
    const SpringBox& box = scene.box();
    const Size3 extent = box.extent();
    testing::for_each_row_of(box, 1, [&](const SpringRun& run) {
      RunVectors mine;
      RunVectors theirs;
      MAILLE_OF_WIDTH(spring_forces)(box, run, mine);
      spring_forces(box, run, theirs);
      ASSERT_TRUE(same_bits(mine, theirs, run.count)) << "forces";

      const SpringSums a = MAILLE_OF_WIDTH(spring_sums)(box, run, scene.way());
      const SpringSums b = spring_sums(box, run, scene.way());
      ASSERT_TRUE(a.energy == b.energy && a.curvature == b.curvature) << "sums";

      const float* const d = &scene.direction()[0][run.first];
      const float* const e = &scene.direction()[1][run.first];
      ASSERT_EQ(MAILLE_OF_WIDTH(dot_of_run)(d, e, run.count), dot_of_run(d, e, run.count));

      std::array<RowsAround, 3> rows;
      for (std::size_t c = 0; c < 3; ++c) {
        for (int r = 0; r < 9; ++r) {
          const std::int64_t step = (std::int64_t{r / 3 - 1} * extent.y + (r % 3 - 1)) * extent.x;
          rows[c].at[static_cast<std::size_t>(r)] = &scene.direction()[c][run.first + step];
        }
      }
      MAILLE_OF_WIDTH(laplacian)(box, run, rows, mine);
      laplacian(box, run, rows, theirs);
      ASSERT_TRUE(same_bits(mine, theirs, run.count)) << "laplacian";

      for (int s = 0; s < kSprings; ++s) {
        MAILLE_OF_WIDTH(stiffnesses)(box, run, s, mine.x);
        stiffnesses(box, run, s, theirs.x);
        ASSERT_TRUE(same_bits(mine.x, theirs.x, run.count)) << "stiffness";
      }

      const auto m = MAILLE_OF_WIDTH(measure_cells)(box, run.first, run.count, mine.x);
      const auto t = measure_cells(box, run.first, run.count, theirs.x);
      ASSERT_TRUE(same_bits(mine.x, theirs.x, run.count)) << "cells";
      ASSERT_TRUE(m.least == t.least && m.longest_edge == t.longest_edge);
    });
  }
}

}  // namespace
}  // namespace maille
