#include "resample/resample_counts.h"

namespace maille {

ResampleCounts& ResampleCounts::operator+=(const ResampleCounts& other) {
  voxels += other.voxels;
  moved_voxels += other.moved_voxels;
  background_voxels += other.background_voxels;
  unfilled_voxels += other.unfilled_voxels;
  copied_voxels += other.copied_voxels;
  copy_seconds += other.copy_seconds;
  resample_seconds += other.resample_seconds;
  return *this;
}

void ResampleCounts::timed(double seconds) {
  if (moved_voxels > 0) {
    resample_seconds = seconds;
  } else {
    copied_voxels = voxels;
    copy_seconds = seconds;
  }
}

}  // namespace maille
