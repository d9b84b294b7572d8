// How much of a material's springs minds direction, where the table does not say.
//
// A quarter for the medium that deforms: springs alone buckle under compression and then have no one
// equilibrium (starts that differ end 1.3 voxels apart; with 1/8 and more, in the same place to
// 1e-6). A stiffer material gets as much less as it is stiffer: it does not buckle, and what minds
// direction minds being turned. With a quarter for all, a ball 1000 times as stiff as a sheared
// medium around it turns by 0.7 % of what it should, with this by 99 % (maille measure error --stage
// relaxation).
//
// The medium is the material in the middle of those neither fixed nor rigid, by stiffness (of two
// in the middle the softer): the softest of all may be air.
#pragma once

#include <vector>

#include "material/material.h"

namespace maille {

// Gives one to each that has none.
void give_default_blends(std::vector<Material>& materials);

}  // namespace maille
