// Relaxation: from the ChainMail answer to the equilibrium of the springs.
//
// The least energy of springs (springs.h) and corners near folding (fold_energy.h), with handles,
// pins, anchors and fixed materials where they are, found by nonlinear conjugate gradients
// (Polak-Ribiere, restarted) on forces that multigrid has turned into moves
// (stiffness_multigrid.h), and those on stiff parts into turns (stiff_turns.h). A step goes to the
// least energy along its direction by the energy's own second derivative; where that is not
// positive, by the bound that no stretch exceeds. FoldGuard takes it, so no cell that was open is
// folded after it.
//
// The moves that multigrid gives, times the length of the step they are about to take and how much
// the steps after it add to it, are what is left to the equilibrium as far as one cycle can tell;
// what multigrid hardly sees shows in how far the state came over many of them (state_trail.h). The
// larger of the two is the estimate, and a relaxation is over when it has been within a third of
// the tolerance twice, for it may be three times too small. What is given out stands where it
// ended, or the estimate counts how far it stayed behind.
//
// Carved elements, and any that nothing holds to the rest, stay where they are. Springs do not take
// stiffness as it stands: material/spring_table.h says why and how.
//
// Where handles have been released of material that yields, a relaxation has three parts: the
// springs find their equilibrium with those handles still held, the material flows from there, once
// (yield_flow.h), and the springs find the one without the handles. So what stays does not depend
// on how long a person waited before letting go.
//
// The paper's way (Jacobi steps for a list of elements that still move) is what maille measure
// error --stage relaxation compares with.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "core/parallel.h"
#include "deform/anchors.h"
#include "deform/cuts.h"
#include "deform/lattice.h"
#include "material/material_field.h"

namespace maille {

struct RelaxationOptions {
  double tolerance_voxels = 0.01;  // over when the estimated largest distance is within it
  // What it may take beside the lattice; as much of what surrounds the drag relaxes as fits.
  std::int64_t memory_bytes = std::numeric_limits<std::int64_t>::max();
};

struct RelaxationProgress {
  std::int64_t iterations = 0;
  std::int64_t element_updates = 0;  // free elements times iterations
  std::int64_t free_elements = 0;
  double energy_first = 0.0;      // of all springs and corners with a free end, stiffness * mm^2
  double energy_last = 0.0;       // of the state that lattice() gave, or reached since
  bool energy_ever_rose = false;  // between two states that lattice() could give
  // Estimated distances to equilibrium; infinite before the first iteration.
  double residual_voxels = std::numeric_limits<double>::infinity();  // the largest
  double residual_rms_voxels = std::numeric_limits<double>::infinity();
  std::int64_t folded_corners = 0;  // that ChainMail left, and are still there
  bool region_limited = false;      // memory did not allow for all that is pulled: its rim holds
  bool converged = false;  // within the tolerance though the estimate be three times too small
  bool no_nearer = false;  // not, but nothing gets better any more
  bool finished() const { return converged || no_nearer; }
};

// What has to do with material that yields.
struct Yielding {
  Lattice kept = {};         // displacements that it keeps so far (P of springs.h); none: 0
  ElementSet released = {};  // held until it has flown
};

class Relaxation {
 public:
  // held: elements that stay where they are (handles, pins). disturbed: what is not in equilibrium
  // to begin with; none: all that has moved. The field must outlive this; start and cuts are of its
  // volume. Throws std::bad_alloc.
  Relaxation(const Lattice& start, const MaterialField& materials, const Cuts& cuts,
             const ElementSet& held, AnchorRules anchors, WorkerPool& pool,
             const RelaxationOptions& options,
             const std::optional<VoxelBox>& disturbed = std::nullopt,
             const Yielding& yielding = {});
  ~Relaxation();
  Relaxation(Relaxation&&) noexcept;

  // One cycle. Bit-equal for any number of threads. Throws Failure where the state is not finite
  // any more, naming an element.
  const RelaxationProgress& iterate();
  const RelaxationProgress& progress() const;

  // The state of least energy so far, rounded to fixed point; bricks that did not change are the
  // same shared bricks.
  Lattice lattice();
  // What material keeps since it has flown, from when on the states above are those after it; null
  // before, and where nothing was released.
  const Lattice* kept_by_flow() const;
  // Unrounded, of all elements of the volume, x fastest: for measuring.
  std::vector<glm::dvec3> displacements_voxels() const;

  std::int64_t bytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace maille
