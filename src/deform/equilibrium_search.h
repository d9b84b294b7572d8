// The search for the least energy of a box of springs: relaxation.h says how and why.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>

#include "core/parallel.h"
#include "deform/box_array.h"
#include "deform/fold_guard.h"
#include "deform/lattice.h"
#include "deform/spring_box.h"
#include "deform/stiff_turns.h"
#include "deform/stiffness_multigrid.h"

namespace maille {

class EquilibriumSearch {
 public:
  // From the state the box is in, or, in a large box, from the equilibrium of the same box at half
  // the resolution, found the same way: what has far to go goes there at an eighth of the cost.
  // Throws std::bad_alloc; Failure as cycle() does.
  EquilibriumSearch(std::unique_ptr<SpringBox> box, WorkerPool& pool);

  // One step and the aim of the next. Throws Failure where the state is not finite any more, naming
  // the voxel.
  void cycle();

  const SpringBox& box() const { return *box_; }
  // Of all springs and corners with a free end, stiffness * mm^2.
  double energy() const { return energy_; }
  double energy_at_start() const { return energy_at_start_; }  // of the state the box was in

  // The state in fixed point.
  struct Rounded {
    Lattice lattice;
    double energy = 0.0;
    std::vector<CellCorner> at_risk;  // all corners that rounding may have folded
  };
  // published: as SpringBox::lattice has it; settled: for its energy, which takes longer
  // (settle_rounding.h).
  Rounded rounded(const Lattice& published, bool settled);
  // Estimated distances to equilibrium, of all elements and of the furthest.
  double rms_voxels() const { return rms_voxels_; }
  double largest_voxels() const { return largest_voxels_; }
  // Of the furthest: what floats leave open. They keep a displacement to 2^-24 of it, and what
  // springs make of that adds up along the way to what is held (30 to 200 times that, measured with
  // pulls of 10^3 to 10^6 voxels).
  double rounding_voxels() const { return 64 * 0x1p-24 * guard_.largest_u_voxels(); }
  std::int64_t folded_corners() const { return guard_.folded(); }
  std::int64_t bytes() const;

 private:
  template <std::size_t kSums, class F>
  std::array<double, kSums> over_rows(int margin, F&& f);

  double spring_energy();
  void start_from_half_resolution();
  void aim(bool first);
  void compute_forces();
  void solve_for_moves(bool with_turns);
  double turn(float keep);
  void measure(double slope, double moves_squared, bool first);
  double length_of_step(double slope, double curvature, double folds);
  void estimate(double step, double moves_squared);
  void check_finite(double sum) const;

  WorkerPool& pool_;
  std::unique_ptr<SpringBox> box_;
  StiffnessMultigrid multigrid_;
  FoldGuard guard_;
  BoxVectors forces_;
  BoxVectors moves_;        // what multigrid makes of them
  BoxDirection direction_;  // of the next step
  StiffTurns turns_;
  bool leapt_ = true;  // from half the resolution, and that from half of it
  double step_ = 0.0;
  double furthest_voxels_ = 0.0;  // of a step of 1
  double moves_dot_forces_ = 0.0;
  double caution_ = 1.0;           // share of the step that is taken
  double longest_step_ = 0.0;      // that is believed
  double share_of_corners_ = 0.0;  // of their curvature that counts
  double energy_ = 0.0;            // the least so far
  double last_energy_ = 0.0;
  double energy_at_start_ = 0.0;
  double rms_voxels_ = std::numeric_limits<double>::infinity();
  double largest_voxels_ = std::numeric_limits<double>::infinity();
};

}  // namespace maille
