// A box of springs and the same at half the resolution, where moves that reach far are found
// cheaply (SpringBox::at_half_resolution makes it).
#pragma once

#include "deform/spring_box.h"

namespace maille {

// What the elements of a half-resolution box have moved since they were at `before`, interpolated
// to the free elements of the fine one; 0 at the others. Without `before`, what takes these to
// where the half-resolution box says that they are. Returns how far the furthest goes, in fine
// voxels.
double interpolate_moves(const SpringBox& half, const BoxVectors* before, const SpringBox& fine,
                         BoxVectors& moves, WorkerPool& pool);

}  // namespace maille
