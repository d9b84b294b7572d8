// The loops over rows of values compiled by hand for one vector width, against those that the
// loader chose: every bit. A test file a width defines MAILLE_WIDTH, what to call the version, and
// MAILLE_FOR_THIS_WIDTH, then includes this.
#include <gtest/gtest.h>

#include "core/several_widths.h"
#include "tests/resample/row_sampler_scenes.h"

#undef MAILLE_FOR_SEVERAL_WIDTHS
#define MAILLE_FOR_SEVERAL_WIDTHS MAILLE_FOR_THIS_WIDTH
#define MAILLE_JOIN_(a, b) a##b
#define MAILLE_JOIN(a, b) MAILLE_JOIN_(a, b)
#define MAILLE_OF_WIDTH(name) MAILLE_JOIN(name, MAILLE_WIDTH)
#define RowSampler MAILLE_OF_WIDTH(RowSampler)
// The source itself: there is no other way to a version that the loader would not choose.
#include "resample/row_sampler.cpp"
#undef RowSampler

namespace maille {
namespace {

TEST(MAILLE_OF_WIDTH(RowSamplerOf), SameBitsAsTheLoadersChoice) {
  if (!MAILLE_HAS_THIS_WIDTH) GTEST_SKIP() << "not on this machine";
  for (unsigned seed = 0; seed < 6; ++seed) {
    const auto mine = testing::sampled_by<MAILLE_OF_WIDTH(RowSampler)>(seed);
    ASSERT_GT(mine.size(), 5000u);
    EXPECT_EQ(mine, testing::sampled_by_loaders_choice(seed)) << "seed " << seed;
  }
}

}  // namespace
}  // namespace maille
