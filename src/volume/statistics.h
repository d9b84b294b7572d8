// What a volume's samples are like: what `maille info` prints and what default views start from.
#pragma once

#include <cstdint>
#include <vector>

#include "volume/volume.h"

namespace maille {

struct VolumeStatistics {
  double lowest = 0.0;  // over finite samples; both 0 when there are none
  double highest = 0.0;
  std::int64_t nan_count = 0;           // NaN and infinite samples (float volumes only)
  std::vector<std::int64_t> histogram;  // equal bins from lowest to highest, both included
};

VolumeStatistics statistics_of(const Volume& volume, int bins = 256);

}  // namespace maille
