#include "measure/resample_bars.h"

#include <algorithm>
#include <utility>

namespace maille {
namespace {

using Row = ResampleError::Row;
using Scene = ResampleError::Scene;

constexpr int kThreads = 2;          // of the speeds
constexpr double kCopyShare = 70.0;  // percent
constexpr double kTimesFloor = 1.05;

}  // namespace

std::optional<double> million_voxels_bar(const std::string& method) {
  if (method == "nearest" || method == "linear") return 120.0;
  if (method == "barycentric") return 80.0;
  if (method == "rbf") return 35.0;
  return std::nullopt;
}

bool has_bars(const Scene& scene) { return scene.moves && !scene.folds; }

std::vector<ResampleBar> bars_of(const ResampleError& report) {
  std::vector<ResampleBar> speeds, errors, counts;
  // Of a kind of voxels that there should be none of, over all scenes.
  const auto count = [&](const std::string& what, int threads, std::int64_t voxels) {
    auto bar = std::find_if(counts.begin(), counts.end(),
                            [&](const ResampleBar& other) { return other.what == what; });
    if (bar == counts.end()) {
      bar = counts.insert(bar, {what, "all scenes", threads, 0.0, 0.0, false, "voxels"});
    }
    bar->measured += static_cast<double>(voxels);
  };
  for (const Scene& scene : report.scenes) {
    // What 1 and more threads show is the same: errors have one bar.
    std::string seen;
    for (const Row& row : scene.rows) {
      if (row.way != "maille") continue;
      const auto bar = million_voxels_bar(row.method);
      if (has_bars(scene) && row.threads == kThreads && bar) {
        speeds.push_back({row.method, scene.title, row.threads, row.million_voxels_per_second(),
                          *bar, true, "M voxels/s"});
      }
      if (row.method == std::exchange(seen, row.method)) continue;
      const auto times_floor = row.deviation ? row.deviation->times_floor() : std::nullopt;
      if (has_bars(scene) && row.method == "linear" && times_floor) {
        errors.push_back({"linear, RMS error", scene.title, row.threads, *times_floor, kTimesFloor,
                          false, "x the grid's"});
      }
      if (row.found) count("nearest, another is nearer", row.threads, row.found->wrong);
      if (row.deviation) {
        count(row.method + ", nothing shown", row.threads, row.deviation->unfilled_voxels);
      }
    }
  }
  std::vector<ResampleBar> bars = std::move(speeds);
  for (const ConstantBricks& bricks : report.constant_bricks) {
    bars.push_back({"constant bricks", "shifted by (5, -3, 2) voxels", bricks.threads,
                    100.0 * bricks.share_of_copy(), kCopyShare, true, "% of a copy"});
  }
  bars.insert(bars.end(), errors.begin(), errors.end());
  bars.insert(bars.end(), counts.begin(), counts.end());
  return bars;
}

}  // namespace maille
