// Several timings of the same work in a few numbers.
#pragma once

#include <vector>

namespace maille {

struct Timing {
  double median_seconds = 0.0;
  double least_seconds = 0.0;
  double most_seconds = 0.0;
  int runs = 0;
};

// An even number of runs has two medians; the slower one counts. seconds is not empty.
Timing timing_of(std::vector<double> seconds);

// The least of the values that at least this share of them (0 < share <= 1) does not exceed. values
// is not empty.
double percentile(std::vector<double> values, double share);

}  // namespace maille
