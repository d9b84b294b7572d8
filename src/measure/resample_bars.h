// What resampling has to reach: the numbers that Maille answers to, each beside what was measured.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "measure/resample_error.h"

namespace maille {

struct ResampleBar {
  std::string what;
  std::string scene;  // its title
  int threads = 1;
  double measured = 0.0;
  double bar = 0.0;
  bool at_least = true;  // else at most
  const char* unit = "";

  bool met() const { return at_least ? measured >= bar : measured <= bar; }
};

// Million voxels/s of a method in moved scenes on two threads. None: no such method.
std::optional<double> million_voxels_bar(const std::string& method);

// Whether the numbers that Maille answers to are about a scene: one that moves by other than whole
// voxels and does not fold.
bool has_bars(const ResampleError::Scene& scene);

// Of what was measured: where a number of threads or a method that has a bar is missing, so is the
// bar. Speeds are meant for the two shared cores that Maille is made on.
std::vector<ResampleBar> bars_of(const ResampleError& report);

}  // namespace maille
