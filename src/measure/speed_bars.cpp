#include "measure/speed_bars.h"

#include <algorithm>

namespace maille {
namespace {

using Row = SpeedReport::Row;

constexpr std::int64_t kMillion = 1'000'000;

// Of all rows, by f(row).
template <class F>
double most(const SpeedReport& report, F&& f) {
  double highest = 0.0;
  for (const Row& row : report.rows) highest = std::max(highest, f(row));
  return highest;
}

void add_speeds(const SpeedReport& report, std::vector<SpeedBar>& bars) {
  struct Floor {
    const char* what;
    const char* group;
    std::int64_t elements;  // 0: as many as the scene has
    int threads;
    double million_per_second;
  };
  static constexpr Floor kFloors[] = {{"one axis, 1 M elements", "one_axis", kMillion, 1, 200},
                                      {"one axis, 1 M elements", "one_axis", kMillion, 2, 300},
                                      {"general direction, 1 M", "general", kMillion, 1, 70},
                                      {"general direction, 1 M", "general", kMillion, 2, 110},
                                      {"stiff ball", "stiff_ball", 0, 1, 200},
                                      {"stiff ball", "stiff_ball", 0, 2, 300},
                                      {"random 8³ blocks", "random_blocks", 0, 2, 40}};
  for (const Floor& floor : kFloors) {
    const Row* const row = report.find(floor.group, floor.threads, floor.elements);
    if (!row) continue;
    bars.push_back({floor.what, floor.threads, 1e-6 * row->elements_per_second(),
                    floor.million_per_second, true, "M elements/s", row});
  }
}

void add_times(const SpeedReport& report, std::vector<SpeedBar>& bars) {
  for (const auto& [threads, triad] : report.machine.triad_gb_per_s) {
    if (const Row* const row = report.find("one_axis", threads, kMillion / 10)) {
      bars.push_back({"one axis, 100 k elements", threads, 1e3 * row->next.median_seconds, 1.0,
                      false, "ms", nullptr});
    }
    for (const char* const group : {"one_axis", "general"}) {
      const double exponent = report.growth(group, threads);
      if (exponent == 0.0) continue;
      bars.push_back(
          {group == std::string("general") ? "growth, general direction" : "growth, one axis",
           threads, exponent, 1.05, false, "exponent", nullptr});
    }
    // The small volume's row comes before the large one's.
    std::vector<const Row*> sizes;
    for (const Row& row : report.rows) {
      if (row.group == "volume_size" && row.threads == threads) sizes.push_back(&row);
    }
    if (sizes.size() == 2) {
      bars.push_back({"large volume against small", threads,
                      sizes[1]->next.median_seconds / sizes[0]->next.median_seconds, 1.1, false,
                      "times as long", nullptr});
    }
  }
  for (const SpeedReport::Pointer& pointer : report.pointers) {
    if (pointer.threads != 2) continue;
    bars.push_back({"pointer, 99th percentile", pointer.threads,
                    1e3 * pointer.percentile_99_seconds, 33.0, false, "ms", nullptr});
    bars.push_back({"pointer, slowest position", pointer.threads, 1e3 * pointer.all.most_seconds,
                    33.0, false, "ms", nullptr});
  }
}

void add_memory(const SpeedReport& report, std::vector<SpeedBar>& bars) {
  if (report.rows.empty()) return;
  const int threads = report.rows.front().threads;
  bars.push_back({"lattice at rest, worst drag", threads,
                  most(report, [](const Row& row) { return row.at_rest.bytes_per_element(); }), 8.0,
                  false, "bytes/element", nullptr});
  bars.push_back({"during a stroke, between positions", threads,
                  most(report, [](const Row& row) { return bytes_per_element(row.in_stroke); }),
                  16.0, false, "bytes/element", nullptr});
  bars.push_back({"during a stroke, while it is solved", threads,
                  most(report, [](const Row& row) { return bytes_per_element(row.at_most); }), 16.0,
                  false, "bytes/element", nullptr});
  if (const Row* const row = report.find("large_volume", threads, kMillion)) {
    bars.push_back({"lattice of 1 M in the large volume", threads,
                    1e-6 * static_cast<double>(row->at_rest.bytes), 30.0, false, "MB", nullptr});
  }
}

}  // namespace

std::vector<SpeedBar> bars_of(const SpeedReport& report) {
  std::vector<SpeedBar> bars;
  add_speeds(report, bars);
  add_times(report, bars);
  add_memory(report, bars);
  return bars;
}

}  // namespace maille
