// The exact answer by Dijkstra's algorithm, one component after the other over the whole volume: no
// bricks, no tricks, 64-bit labels. What the product must equal in every bit.
#pragma once

#include "references/dense_problem.h"

namespace maille {

// moved_by is less than problem.by where something immovable holds the handle back. A link that is
// outside its limits at the start counts as having no slack.
DenseAnswer exact_dijkstra(const DenseProblem& problem);

}  // namespace maille
