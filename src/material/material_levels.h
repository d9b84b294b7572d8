// The materials that voxels really get: one a range of values, or with interpolation up to 256
// steps of a ramp from range to range. A level is a material like any other, so nothing that reads
// ids of materials knows which of the two it is.
#pragma once

#include <cstdint>
#include <vector>

#include "material/material.h"

namespace maille {

inline constexpr int kMaxMaterials = 256;  // and levels: an id is 8 bits

// step: a value has the numbers of its range.
// linear: a material's own numbers hold in the middle of its range; from there to the middle of the
// next range limits and blend run straight and stiffness geometrically (its logarithm straight),
// across any gap; before the first middle and after the last they stay. A range open at one end has
// its numbers up to its finite end, for its middle lies at infinity. `fixed` and `rigid` go by
// range (in gaps, the nearest) whatever the ramp: a rigid material is exactly rigid all over its
// range.
//
// Of a yield strain y, 1 / (1 + y) runs straight: rest length over length where the link yields, 0
// for one that never does. Small strains run all but straight in it, and a ramp from clay to rubber
// rises without end, with no jump in it; y itself would be infinite all along it.
enum class Interpolation : std::uint8_t { step, linear };

// 1 to 256 materials, each with a blend, by rising, disjoint ranges -> 1 to 256 levels by rising, touching ranges from
// -inf to inf. A gap between ranges belongs to the nearer one, its middle to the lower.
//
// Levels of a ramp are shared out so that the worst is as good as it can be: every middle has one
// of its own with exactly that material's numbers, and between two middles they are equally wide.
// With n materials (n <= 128) whose numbers change by C in all along the values (for each ramp the
// largest of the twelve: nine limits in voxels, ln stiffness, blend, 1 / (1 + y)), no level is
// further from the straight line, anywhere in its range, than the larger of C / (514 - 4 n) and
// 1/1024; finer than that, half a fixed-point unit, would change nothing. (Ranges only a few
// doubles wide are as good as their doubles.)
std::vector<Material> levels_of(const std::vector<Material>& materials,
                                Interpolation interpolation);

}  // namespace maille
