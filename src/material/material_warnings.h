// What about a set of materials may surprise the person who wrote it.
#pragma once

#include <string>
#include <vector>

#include "material/material.h"
#include "material/material_levels.h"

namespace maille {

// Materials that a table has taken, by rising value -> sentences, each naming the materials it is
// about:
// - one for each material whose limits allow a folded cell (component_that_may_fold);
// - one for each stiffer than another whose limits are wider than that one's in some direction:
//   where ChainMail lets it give way first, relaxation would have it the other way round;
// - one for each that has limits, but all below 1/512 voxel, so that it acts as rigid;
// - one at most for the table as a whole, if the force that takes a material to a limit (stiffness
//   times strain) differs between two materials by more than four times: the two steps then want
//   different shapes (the paper, section 5.3). Four, because each number is good to a factor of
//   two: tissue of one kind differs as much from body to body, and people type round numbers. Only
//   the worst pair is named, and not twice: what is wrong with it is mostly wrong with others too;
// - one at most where interpolation makes forces part by as much between two neighbours. Limits run
//   straight and stiffness geometrically, so halfway between limits that limits_from_stiffness made
//   for stiffness 1 and R, the force is (sqrt(R) + 1/sqrt(R)) / 2 times that at either end. (The
//   no-fold rule needs no such look: what both ends keep, every straight line between them keeps.)
// Fixed materials do not deform and rigid ones have no limits to compare: only the first sentence
// is about them. Nor is a direction in which a material has no room at all compared by force.
std::vector<std::string> warnings_of(const std::vector<Material>& materials,
                                     Interpolation interpolation);

}  // namespace maille
