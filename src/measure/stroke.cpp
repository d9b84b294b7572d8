#include "measure/stroke.h"

#include "core/stopwatch.h"

namespace maille {

Result<TimedDrag> timed_drag(Deformer& deformer, glm::dvec3 by_voxels, WorkerPool& pool) {
  const Stopwatch start;
  auto report = deformer.drag_to(by_voxels, pool);
  const double seconds = start.seconds();
  if (!report) return report.error();
  return TimedDrag{*report, seconds};
}

double LatticeUse::bytes_per_element() const {
  if (bricks == 0) return 0.0;
  return static_cast<double>(bytes) / (static_cast<double>(bricks) * kBrickVoxels);
}

LatticeUse memory_of(const Deformer& deformer) {
  return {deformer.lattice().brick_count(), deformer.lattice().bytes()};
}

}  // namespace maille
