// The machine a measurement was made on.
#pragma once

#include <map>
#include <span>
#include <string>

namespace maille {

struct Machine {
  std::string processor;  // as the kernel names it; "unknown processor" where it does not
  int hardware_threads = 1;
  std::map<int, double> triad_gb_per_s;  // by number of threads
};

// Measures the triad for each number of threads, in this very run: shared machines change.
Machine this_machine(std::span<const int> thread_counts);

// "AMD EPYC, 2 hardware threads, triad 14.2 GB/s on 1 thread, 21.0 on 2".
std::string text_of(const Machine& machine);

}  // namespace maille
