// The springs that cuts leave no way for.
#pragma once

#include <cstdint>
#include <vector>

#include "deform/cuts.h"
#include "deform/springs.h"

namespace maille {

// A bit a spring of `springs`, for each element of a brick; empty where none is missing, as nearly
// everywhere. A spring along an axis goes with its link. One across a face goes when both ways
// round that face, of two links each, are broken: what still hangs together through the face stays
// stiff, and nothing holds across a cut. A carved element has no links and so no springs.
std::vector<std::uint32_t> missing_springs(const Cuts& cuts, std::int64_t brick,
                                           const Springs& springs);

}  // namespace maille
