// Bricks that are displaced by one whole number of voxels: no more than a copy, and held against
// one.
#pragma once

#include <cstdint>

#include "core/parallel.h"
#include "measure/timing.h"

namespace maille {

struct ConstantBricks {
  int threads = 1;
  std::int64_t bytes = 0;  // read and written
  Timing resampled;
  Timing copied;  // the same bytes, brick by brick, by memcpy

  double gb_per_s() const;       // resampled
  double copy_gb_per_s() const;  // copied
  double share_of_copy() const;  // resampled, of copied
};

// A volume of edge^3 floats. The two take turns, so that both meet the same machine.
ConstantBricks measure_constant_bricks(int edge, int runs, WorkerPool& pool);

}  // namespace maille
