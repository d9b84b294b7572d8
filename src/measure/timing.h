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

// How often to do the same: at least `least` times, and up to `runs` while they would take no more
// than `seconds` in all.
struct RunLimit {
  int runs = 1;
  double seconds = 1.0;
  int least = 1;
};

// What each run took; run() returns its seconds.
template <class F>
std::vector<double> seconds_of_runs(const RunLimit& limit, F&& run) {
  std::vector<double> seconds;
  double all = 0.0;
  do {
    seconds.push_back(run());
    all += seconds.back();
  } while (
      static_cast<int>(seconds.size()) < limit.runs &&
      (static_cast<int>(seconds.size()) < limit.least || all + seconds.back() <= limit.seconds));
  return seconds;
}

// The least of the values that at least this share of them (0 < share <= 1) does not exceed. values
// is not empty.
double percentile(std::vector<double> values, double share);

}  // namespace maille
