// What a drag has to reach: the numbers that Maille answers to, each beside what was measured.
#pragma once

#include <string>
#include <vector>

#include "measure/speed.h"

namespace maille {

struct SpeedBar {
  std::string what;
  int threads = 1;
  double measured = 0.0;
  double bar = 0.0;
  bool at_least = true;  // else at most
  const char* unit = "";
  const SpeedReport::Row* row = nullptr;  // whose speed it is; null: it is no speed of a drag

  bool met() const { return at_least ? measured >= bar : measured <= bar; }
};

// Of what was measured: where a drag or a number of threads that has a bar is missing, so is the
// bar. Speeds and times are meant for the two shared cores that Maille is made on.
std::vector<SpeedBar> bars_of(const SpeedReport& report);

}  // namespace maille
