// Maille's own resampling of a volume of floats, as a program that shows it would have it: with a
// resampler made anew, brick by brick into memory that is there already.
#pragma once

#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "resample/resampler.h"

namespace maille {

class ProductResampling {
 public:
  // Shown where nothing lies. No value of a scene.
  static constexpr float kBackground = -1.0f;

  // Of all bricks.
  ProductResampling(Volume volume, Lattice lattice);

  // Leaves out the bricks that showed nothing when last run.
  void skip_empty_bricks();

  // Seconds, the resampler's set-up counted.
  double run(ResampleMethod method, WorkerPool& pool);

  // Of the last run, by voxel, x fastest; NaN where nothing is shown.
  std::vector<float> shown() const;
  // The inverse map of `linear`; NaN where nothing lies.
  std::vector<glm::vec3> rest_positions(WorkerPool& pool) const;

 private:
  Volume volume_;
  Lattice lattice_;
  std::vector<std::int64_t> bricks_;
  std::vector<float> bricks_shown_;  // brick by brick
};

}  // namespace maille
