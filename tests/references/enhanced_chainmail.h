// Enhanced ChainMail: M. A. Schill, S. F. F. Gibson, H.-J. Bender, R. Männer, Biomechanical
// simulation of the vitreous humor in the eye using an Enhanced ChainMail algorithm, MICCAI 1998;
// what Schulze et al. 2007 build on.
//
// The element whose constraint is violated most is next (a heap), moves as little as the link to
// the element that pushed it asks for, all three components at once, and is then done: each element
// is visited once. That is Dijkstra's algorithm where one order serves all three components, as in
// one material from rest; elsewhere an element may be done before the component that needed
// another order has come.
#pragma once

#include "references/dense_problem.h"

namespace maille {

// The method knows no anchor that holds the handle back: what is immovable stays and passes nothing
// on, and moved_by is problem.by.
DenseAnswer enhanced_chainmail(const DenseProblem& problem);

}  // namespace maille
