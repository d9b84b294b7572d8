// Relaxation: from the ChainMail answer towards the equilibrium of the springs.
//
// Springs run to the 6 axis neighbours and the 12 face diagonals, equal k (isotropic, Poisson's
// ratio 1/4, no zero-energy mode), stiffness of both materials in series, rest lengths in mm:
//
//     f_ij = -k_ij (|p_ij| - d_ij) p_ij / |p_ij|       (the paper's eq. (4), sign and scale mended)
//
// of which a share `rest_vector_blend` is a spring on the rest vector, f = -k (p_ij - r_ij), that
// keeps compressed cells from buckling. The Hessian is at most the stiffness-weighted graph
// Laplacian at any stretch, so a step of g_i * step / sum_j k_ij with step < 1 lowers the energy
// from any state at any ratio of stiffness.
//
// No spring crosses a cut or ends at a carved element (missing_springs.h has the rule): what is
// left of an element's springs makes its energy, its safe step and its force. Carved elements, and
// any that nothing holds, stay where they are.
//
// Work follows an active list of bricks, looked through once in 16 sweeps: a brick in which nothing
// moves by more than a thousandth of the tolerance rests, until something moves more at the face of
// a brick beside it.
#pragma once

#include <memory>
#include <vector>

#include "core/parallel.h"
#include "deform/anchors.h"
#include "deform/cuts.h"
#include "deform/lattice.h"
#include "material/material_field.h"

namespace maille {

struct RelaxationOptions {
  double tolerance_voxels = 0.01;   // stop when the estimated distance to equilibrium is below
  double step = 0.95;               // of the safe step, in (0, 1)
  double rest_vector_blend = 0.25;  // 0: springs alone; 1: rest vectors alone
};

struct RelaxationProgress {
  std::int64_t iterations = 0;
  std::int64_t element_updates = 0;
  double energy_first = 0.0;  // of all springs that are out of rest, stiffness * mm^2
  double energy_last = 0.0;   // when last measured: every 16 iterations, at the end, by measure()
  bool energy_ever_rose = false;     // between two of these
  double largest_move_voxels = 0.0;  // in the last iteration
  double residual_voxels = 0.0;      // estimated largest distance to equilibrium; infinite until
                                     // there are moves enough to tell (16 iterations)
  bool converged = false;            // residual_voxels is within the tolerance
  bool at_float_limit = false;       // not, but moves have shrunk to the rounding of the state
  bool finished() const { return converged || at_float_limit; }
};

class Relaxation {
 public:
  // held: elements that stay where they are (handles, pins). The field must outlive this; start and
  // cuts are of its volume.
  Relaxation(const Lattice& start, const MaterialField& materials, const Cuts& cuts,
             const ElementSet& held, AnchorRules anchors, WorkerPool& pool,
             const RelaxationOptions& options);
  ~Relaxation();
  Relaxation(Relaxation&&) noexcept;

  // One sweep of every active brick. Bit-equal for any number of threads.
  const RelaxationProgress& iterate();
  const RelaxationProgress& progress() const;
  // Brings the energy up to date, for who stops before the end.
  const RelaxationProgress& measure();

  // The state now, rounded to fixed point; bricks that did not change since the last call are the
  // same shared bricks.
  Lattice lattice();

  std::int64_t bytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace maille
