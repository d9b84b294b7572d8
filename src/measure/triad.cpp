#include "measure/triad.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/parallel.h"
#include "core/stopwatch.h"

namespace maille {

double measure_triad_gb_per_s(int threads) {
  constexpr std::size_t kChunk = std::size_t{1} << 20;
  constexpr std::size_t kChunks = 8;  // three arrays of 64 MiB
  constexpr int kRounds = 4;          // the first one meets the pages
  std::vector<double> a(kChunk * kChunks);
  std::vector<double> b(kChunk * kChunks, 1.0);
  std::vector<double> c(kChunk * kChunks, 2.0);
  WorkerPool pool(threads);
  double best = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    const Stopwatch start;
    pool.for_each(kChunks, [&](std::int64_t chunk, int) {
      const auto begin = static_cast<std::size_t>(chunk) * kChunk;
      for (std::size_t i = begin; i < begin + kChunk; ++i) a[i] = b[i] + 0.5 * c[i];
    });
    const double bytes = static_cast<double>(3 * sizeof(double) * kChunk * kChunks);
    best = std::max(best, bytes / start.seconds() / 1e9);
  }
  return best;
}

}  // namespace maille
