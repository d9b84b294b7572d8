// A stroke on a deformer, timed: the one place where this room meets the deformer's calls for it.
#pragma once

#include <cstdint>
#include <optional>

#include "core/parallel.h"
#include "core/result.h"
#include "deform/deformer.h"

namespace maille {

// What is grabbed and where it is dragged to.
struct Grab {
  VoxelIndex element{0};
  double radius_voxels = 0.0;
  glm::dvec3 by_voxels{0};
};

struct TimedDrag {
  DragReport report;
  double seconds = 0.0;  // until the answer is there
  StrokePeak peak;
  StrokeMemory memory;  // with the answer there
};

// One position of the pointer. Errors: as Deformer::drag_to.
Result<TimedDrag> timed_drag(Deformer& deformer, glm::dvec3 by_voxels, WorkerPool& pool);

// Memory of the lattice as it is now.
struct LatticeUse {
  std::int64_t bricks = 0;    // that hold elements
  std::int64_t elements = 0;  // of these bricks, moved or not
  std::int64_t bytes = 0;     // of these bricks

  double bytes_per_element() const;  // of a touched brick; 0 where none is
};
LatticeUse memory_of(const Deformer& deformer);
double bytes_per_element(const StrokeMemory& memory);  // the same
double bytes_per_element(const StrokePeak& peak);      // the same

}  // namespace maille
