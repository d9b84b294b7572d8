#include "volume/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/trace.h"

namespace maille {
namespace {

class Histogram {
 public:
  Histogram(double lowest, double highest, int bins)
      : lowest_(lowest), bins_per_unit_(highest > lowest ? bins / (highest - lowest) : 0.0) {}
  std::size_t bin(double value, std::size_t bins) const {
    return std::min(static_cast<std::size_t>((value - lowest_) * bins_per_unit_), bins - 1);
  }

 private:
  double lowest_;
  double bins_per_unit_;
};

// 8- and 16-bit samples: count every value there can be, in one pass, and derive the rest. Four
// tables, because neighbours are often equal and would wait for one another's count.
template <class T>
VolumeStatistics count_integers(std::span<const T> voxels, int bins) {
  constexpr std::size_t kValues = std::size_t{1} << (8 * sizeof(T));
  constexpr int kLowest = std::numeric_limits<T>::min();
  std::array<std::vector<std::int64_t>, 4> counts;
  for (auto& table : counts) table.resize(kValues);
  std::size_t i = 0;
  for (; i + 4 <= voxels.size(); i += 4) {
    for (std::size_t k = 0; k < 4; ++k)
      ++counts[k][static_cast<std::size_t>(voxels[i + k] - kLowest)];
  }
  for (; i < voxels.size(); ++i) ++counts[0][static_cast<std::size_t>(voxels[i] - kLowest)];

  const auto count_of = [&](std::size_t v) {
    return counts[0][v] + counts[1][v] + counts[2][v] + counts[3][v];
  };
  VolumeStatistics statistics;
  statistics.histogram.resize(static_cast<std::size_t>(bins));
  std::size_t first = 0, last = kValues - 1;
  while (first < last && count_of(first) == 0) ++first;
  while (last > first && count_of(last) == 0) --last;
  statistics.lowest = static_cast<double>(first) + kLowest;
  statistics.highest = static_cast<double>(last) + kLowest;
  const Histogram histogram(statistics.lowest, statistics.highest, bins);
  for (std::size_t v = first; v <= last; ++v) {
    const auto bin = histogram.bin(static_cast<double>(v) + kLowest, statistics.histogram.size());
    statistics.histogram[bin] += count_of(v);
  }
  return statistics;
}

VolumeStatistics count_floats(std::span<const float> voxels, int bins) {
  VolumeStatistics statistics;
  statistics.histogram.resize(static_cast<std::size_t>(bins));
  float lowest = std::numeric_limits<float>::infinity(), highest = -lowest;
  for (const float value : voxels) {
    if (!std::isfinite(value)) {
      ++statistics.nan_count;
      continue;
    }
    lowest = std::min(lowest, value);
    highest = std::max(highest, value);
  }
  if (!(lowest <= highest)) return statistics;
  statistics.lowest = lowest;
  statistics.highest = highest;
  const Histogram histogram(lowest, highest, bins);
  for (const float value : voxels) {
    if (!std::isfinite(value)) continue;
    ++statistics.histogram[histogram.bin(value, statistics.histogram.size())];
  }
  return statistics;
}

}  // namespace

VolumeStatistics statistics_of(const Volume& volume, int bins) {
  const trace::Span span("statistics");
  bins = std::max(bins, 1);
  return with_voxel_type(volume.type(), [&]<class T>() {
    if constexpr (std::is_same_v<T, float>) {
      return count_floats(volume.voxels<float>(), bins);
    } else {
      return count_integers(volume.voxels<T>(), bins);
    }
  });
}

}  // namespace maille
