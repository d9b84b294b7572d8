// Cutting: a stroke's surface takes the links out that it crosses, and the sides part when dragged.
// Gibson's vision of volumetric surgery (3D ChainMail, 1997), from which the links come too.
#pragma once

#include "core/result.h"
#include "deform/cut_surface.h"
#include "deform/cuts.h"
#include "deform/lattice.h"

namespace maille {

// Axes of more voxels than this cannot be cut.
inline constexpr int kLongestCutAxis_voxels = 1 << 22;

// Removes the links whose deformed segment, from x_i to x_j, meets the surface; cut_triangle.h says
// how it is decided without error, and which side an element exactly on the surface belongs to. Two
// elements in one place are on one side: their link stays.
//
// cuts and lattice are of one volume. Bricks that do not change stay the same shared bricks; the
// cost is that of the bricks that the surface reaches. Errors: usage (a volume of more than
// kLongestCutAxis_voxels along an axis).
Result<Cuts> cut_along(const Cuts& cuts, const Lattice& lattice, const CutSurface& surface);

}  // namespace maille
