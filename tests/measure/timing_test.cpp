#include "measure/timing.h"

#include <gtest/gtest.h>

#include "measure/text_table.h"
#include "measure/triad.h"

namespace maille {
namespace {

TEST(Timing, MedianAndRange) {
  const Timing odd = timing_of({3, 1, 2});
  EXPECT_EQ(odd.median_seconds, 2);
  EXPECT_EQ(odd.least_seconds, 1);
  EXPECT_EQ(odd.most_seconds, 3);
  EXPECT_EQ(odd.runs, 3);
  EXPECT_EQ(timing_of({4, 1}).median_seconds, 4);
  EXPECT_EQ(timing_of({5}).median_seconds, 5);
}

TEST(Timing, NoMoreRunsThanThereIsTimeFor) {
  const auto runs = [](const RunLimit& limit, double each) {
    return seconds_of_runs(limit, [&] { return each; }).size();
  };
  EXPECT_EQ(runs({7, 3.0}, 0.25), 7u);
  EXPECT_EQ(runs({7, 3.0}, 1.0), 3u);
  EXPECT_EQ(runs({7, 3.0}, 0.75), 4u);
  EXPECT_EQ(runs({7, 3.0}, 10.0), 1u);
  EXPECT_EQ(runs({7, 3.0, 3}, 10.0), 3u);
  EXPECT_EQ(runs({1, 3.0}, 0.25), 1u);
}

TEST(Timing, Percentile) {
  std::vector<double> values;
  for (int i = 100; i > 0; --i) values.push_back(i);
  EXPECT_EQ(percentile(values, 0.99), 99);
  EXPECT_EQ(percentile(values, 0.5), 50);
  EXPECT_EQ(percentile(values, 1.0), 100);
  EXPECT_EQ(percentile({7}, 0.99), 7);
}

TEST(TextTable, LinesUpAndQuotes) {
  EXPECT_EQ(text_table({{"name", "ms"}, {"8³", "1.25"}}), "name    ms\n8³    1.25\n");
  EXPECT_EQ(csv({{"a,b", "c"}, {"say \"d\"", ""}}), "\"a,b\",c\n\"say \"\"d\"\"\",\n");
}

TEST(Triad, IsSomeBandwidth) { EXPECT_GT(measure_triad_gb_per_s(1), 0.1); }

}  // namespace
}  // namespace maille
