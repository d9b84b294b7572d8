// What each voxel of a deformed analytic volume should show, from the formula: where it was at
// rest, and the value there.
//
// Judged are voxels all of whose answers lie between elements of the volume: beyond the border
// elements the formula goes on and the volume does not.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "measure/resample_scene.h"
#include "volume/brick.h"

namespace maille {

struct RestTruth {
  glm::dvec3 rest_voxels;
  double value;         // of the formula, as floats hold it
  double interpolated;  // of the undeformed grid there: trilinear, in double precision
};

class ResampleTruth {
 public:
  // values: of the undeformed volume, as it is resampled.
  ResampleTruth(const ResampleScene& scene, Size3 size, std::span<const double> values,
                WorkerPool& pool);

  // Of a voxel (x fastest). More than one where the scene folds; none: it is not judged.
  std::span<const RestTruth> answers(std::size_t voxel) const {
    return std::span(answers_).subspan(first_[voxel], first_[voxel + 1] - first_[voxel]);
  }
  std::int64_t judged_voxels() const { return judged_; }
  // Whose rest position Newton's method did not find: above 0, errors say nothing.
  std::int64_t lost_voxels() const { return lost_; }
  // The furthest that an answer's own place lies from its voxel.
  double worst_forward_voxels() const { return worst_forward_voxels_; }
  // Around all voxels that are judged.
  const VoxelBox& bounds() const { return bounds_; }

 private:
  std::vector<std::size_t> first_;  // [voxel], in answers_; one more at the end
  std::vector<RestTruth> answers_;
  std::int64_t judged_ = 0;
  std::int64_t lost_ = 0;
  double worst_forward_voxels_ = 0.0;
  VoxelBox bounds_;
};

// Of many voxels: the root of the mean square, and the largest.
class Deviation {
 public:
  void add(double size) {
    squares_ += size * size;
    max_ = size > max_ || size != size ? size : max_;  // what is no number stays
    ++count_;
  }
  void add(const Deviation& other);

  double rms() const;
  double max() const { return max_; }
  std::int64_t count() const { return count_; }

 private:
  double squares_ = 0.0;
  double max_ = 0.0;
  std::int64_t count_ = 0;
};

// How far answers of some voxels are from the truth. Where a voxel has several, from the nearest.
struct ResampleDeviation {
  Deviation value;        // of what is shown
  Deviation floor;        // of what the undeformed grid has at the true rest positions
  Deviation rest_voxels;  // of the rest position, where there is one; counts unfilled voxels too
  std::int64_t unfilled_voxels = 0;  // judged, and nothing is shown

  // What is shown, by what the grid itself has; none where that has no error.
  std::optional<double> times_floor() const;
};

// values, rest_voxels: of each voxel of `voxels`, x fastest. values are NaN where nothing is shown.
// rest_voxels may be empty; NaN where there is none.
ResampleDeviation deviation_from(const ResampleTruth& truth, Size3 size, const VoxelBox& voxels,
                                 std::span<const float> values,
                                 std::span<const glm::vec3> rest_voxels, WorkerPool& pool);

}  // namespace maille
