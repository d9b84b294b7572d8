// What resampling has done.
#pragma once

#include <cstdint>

namespace maille {

struct ResampleCounts {
  std::int64_t voxels = 0;
  std::int64_t moved_voxels = 0;       // not owned by an element at rest
  std::int64_t background_voxels = 0;  // covered by no cell
  // Of these, left open though no element of the volume's border has moved, so that nothing can
  // have left the volume, and neither a cut nor carving can have opened them: above 0 there is a
  // bug.
  std::int64_t unfilled_voxels = 0;
  // Known where each brick was timed: a brick in which nothing moved is a copy.
  std::int64_t copied_voxels = 0;
  double copy_seconds = 0.0;      // of one worker after the other
  double resample_seconds = 0.0;  // the same, of all other bricks

  // Says what one brick took, to the counts of this brick alone.
  void timed(double seconds);
  ResampleCounts& operator+=(const ResampleCounts& other);
};

}  // namespace maille
