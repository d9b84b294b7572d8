// The equilibrium of springs by Newton's method in double precision, from any start: what the
// product's relaxation and the paper's are measured against.
//
// Small problems are factorised (Eigen's sparse LDLT) with the exact Hessian, or where that is
// indefinite with each spring's negative curvature taken out. Larger ones take truncated Newton
// steps by conjugate gradients, preconditioned by laplacian_multigrid.h, without a stored matrix
// (some 400 bytes an element in all). A step is taken no further than the energy falls and, with
// the determinant's barrier, no corner with J > 0 turns.
//
// An equilibrium is a minimum near the start, not the only one: cells that buckle have several.
#pragma once

#include "references/dense_springs.h"

namespace maille {

struct EquilibriumOptions {
  double tolerance_voxels = 1e-7;          // of the estimated largest distance, and of the gradient
  std::int64_t largest_factorised = 3000;  // free elements; beyond: conjugate gradients
  int most_newton_steps = 200;
  int most_cg_steps = 5000;  // in one Newton step
  // With the determinant's barrier: a step may carry a corner across J = 0. From a start with many
  // folded cells it gets there in fewer steps so.
  bool may_turn_corners = false;
};

struct Equilibrium {
  DisplacementField u_voxels;
  bool converged = false;  // both by the estimate and by the gradient
  bool stable = false;     // the last Hessian had no direction of negative curvature, as far as the
                           // factorisation (surely) or conjugate gradients (on their way) met one
  double distance_voxels = 0.0;  // estimated largest distance of the state before the last, more
                                 // than what is left: the length of the last Newton step
  double gradient_voxels = 0.0;  // largest gradient over its element's stiffness sum
  double energy = 0.0;           // springs and fold rule, stiffness * mm^2
  double spring_energy = 0.0;
  int newton_steps = 0;
  std::int64_t cg_steps = 0;
  double seconds = 0.0;
};

Equilibrium spring_equilibrium(const SpringProblem& problem, WorkerPool& pool,
                               const EquilibriumOptions& options = {});

}  // namespace maille
