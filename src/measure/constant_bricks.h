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
  Timing copied;  // the same bytes, from end to end, by memcpy
  // Each brick's rows, where they lie in the volume, to one place: what a brick takes of anybody
  // who copies it, since its rows are short and far apart.
  Timing copied_by_rows;

  double gb_per_s() const;       // resampled
  double copy_gb_per_s() const;  // copied
  double rows_gb_per_s() const;  // copied_by_rows
  double share_of_copy() const;  // resampled, of copied
  double share_of_rows() const;  // resampled, of copied_by_rows
};

// A volume of edge^3 floats. The three take turns, so that all meet the same machine.
ConstantBricks measure_constant_bricks(int edge, int runs, WorkerPool& pool);

}  // namespace maille
