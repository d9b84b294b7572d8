// ChainMail in its first form: S. F. F. Gibson, 3D ChainMail: a fast algorithm for deforming
// volumetric objects, Symposium on Interactive 3D Graphics 1997.
//
// First in, first out: an element that moved puts its neighbours at the end of the list; one whose
// link to the element that listed it is violated moves as little as that asks for, once in a drag.
// Right in one material, where a path of fewest links is as good as any; elsewhere elements move
// before what pushes them hardest has arrived. Gibson keeps a list a direction and empties them in
// turn, which in one material is the same and elsewhere another arbitrary order.
#pragma once

#include "references/dense_problem.h"

namespace maille {

// As enhanced_chainmail: what is immovable stays and passes nothing on, moved_by is problem.by.
DenseAnswer fifo_chainmail(const DenseProblem& problem);

}  // namespace maille
