// A deformed scene as the spring references see it.
#pragma once

#include <optional>
#include <span>

#include "measure/stroke.h"
#include "references/dense_springs.h"

namespace maille {

// The springs of a deformer's lattice as it lies now, without a fold rule: what holds are the balls
// of the grabs, fixed materials, stated anchors, and the border where none are stated, as
// Deformer::relax() has it with these grabs pinned. A blend for all materials, or the table's.
SpringProblem spring_problem_of(const Deformer& deformer, std::span<const Grab> pinned,
                                const AnchorRules& anchors,
                                std::optional<double> rest_vector_blend = std::nullopt);

// What relaxation itself keeps cells from folding with (deform/fold_energy.h).
inline constexpr FoldTerm kRelaxationFold{FoldRule::wall, 0.3, 1.0, 1.0 / 3000.0};

// Displacements in double precision, of each element, x fastest.
DisplacementField displacements_of(const Lattice& lattice);

// Between two answers, over the elements that count (1).
struct FieldDistance {
  double rms_voxels = 0.0;
  double max_voxels = 0.0;
};
FieldDistance distance_between(const DisplacementField& a_voxels, const DisplacementField& b_voxels,
                               std::span<const std::uint8_t> counted);

}  // namespace maille
