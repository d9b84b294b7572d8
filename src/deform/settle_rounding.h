// Rounds a state to fixed point where stiff springs mind it.
//
// Each element by itself takes the nearest displacement in fixed point; to a spring a thousand
// times as stiff as those around it, half a unit (1/1024 voxel) is much, and the energy of the
// rounded state tells more of how it happened to be rounded than of where it is. Neighbours that
// mind one another do better: so each takes, in turn, what costs it least within a unit of where it
// is, a few times over.
#pragma once

#include <vector>

#include "core/parallel.h"
#include "deform/fold_energy.h"
#include "deform/spring_box.h"

namespace maille {

// rounded_mm: as SpringBox::round_to_fixed_point() leaves it, and open_rounding() on top; it is not
// touched at the corners given, where more than springs minds it. The same bits for any number of
// threads.
void settle_rounding(const SpringBox& box, const std::vector<CellCorner>& kept,
                     BoxVectors& rounded_mm, WorkerPool& pool);

}  // namespace maille
