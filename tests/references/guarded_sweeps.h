// Relaxation that keeps cells from folding by what each element may do, not by an energy: element
// after element steps down the springs' energy alone (Gauss-Seidel, over-relaxed), as far as its
// guard allows. What such rules end at is no minimum: a step that is stopped may be what two
// elements together could take. Measured beside the energies of FoldRule for that reason.
//
// One thread, double precision.
#pragma once

#include "references/dense_springs.h"

namespace maille {

enum class StepGuard {
  limits,      // no link leaves its ChainMail limits; one that is outside gets no worse
  determinant  // no corner of a cell falls below a least determinant; one below falls no further
};

struct GuardedOptions {
  StepGuard guard = StepGuard::limits;
  double least_determinant = 0.2;  // of StepGuard::determinant
  double step = 1.8;               // of force / stiffness sum; below 2 each lowers the energy
  double still_voxels = 1e-5;      // ends when no element moves by more
  int most_sweeps = 2000;
};

struct GuardedAnswer {
  DisplacementField u_voxels;
  double spring_energy = 0.0;
  int sweeps = 0;
  bool still = false;        // ended because nothing moved
  std::int64_t stopped = 0;  // elements that their guard stopped in the last sweep
  double seconds = 0.0;
};

GuardedAnswer relax_guarded(const SpringProblem& problem, WorkerPool& pool,
                            const GuardedOptions& options);

}  // namespace maille
