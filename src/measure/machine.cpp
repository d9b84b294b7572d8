#include "measure/machine.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <thread>

#include "measure/triad.h"

namespace maille {
namespace {

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("model name")) continue;
    const auto colon = line.find(": ");
    if (colon != line.npos) return line.substr(colon + 2);
  }
  return "unknown processor";
}

}  // namespace

Machine this_machine(std::span<const int> thread_counts) {
  Machine machine;
  machine.processor = processor_name();
  machine.hardware_threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  for (const int threads : thread_counts) {
    machine.triad_gb_per_s[threads] = measure_triad_gb_per_s(threads);
  }
  return machine;
}

std::string text_of(const Machine& machine) {
  std::string text = machine.processor + ", " + std::to_string(machine.hardware_threads) +
                     (machine.hardware_threads == 1 ? " hardware thread" : " hardware threads");
  const char* separator = ", triad ";
  for (const auto& [threads, gb_per_s] : machine.triad_gb_per_s) {
    char number[64];
    std::snprintf(number, sizeof number, "%.1f GB/s on %d %s", gb_per_s, threads,
                  threads == 1 ? "thread" : "threads");
    text += separator + std::string(number);
    separator = ", ";
  }
  return text;
}

}  // namespace maille
