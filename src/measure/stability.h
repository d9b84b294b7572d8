// Whether a deformation ever goes wrong: a drag and its relaxation, in every way that
// stability_case.h knows, watched at each state that relaxation would show.
//
// The promise: energy never rises, nothing becomes non-finite, no cell is folded that was not, no
// link is outside its limits after a drag, and relaxation ends within its tolerance of the
// equilibrium. All of it told by tests/references from displacements alone: energies in double
// precision and folds from the fixed-point lattice, and the equilibrium by Newton's method from
// where relaxation ended. That is the nearest minimum, and where springs buckle not the only one.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/spaces.h"
#include "measure/machine.h"

namespace maille {

struct StabilityOptions {
  int threads = 2;
  int edge = 12;  // of the blocks, voxels
  std::uint64_t seed = 1;
  std::vector<std::string> groups;  // of the sweep; none: all
  double tolerance_voxels = 0.01;
  std::int64_t most_iterations = 1000;
  double most_seconds = 5.0;  // of one relaxation
  std::function<void(const std::string&)> progress = [](const std::string&) {};
};

struct StabilityReport {
  enum class Verdict {
    holds,
    says_so,  // that it comes no nearer, and by how much at most it is off, and so it is
    fails,
    undecided  // but for the distance: the reference did not converge
  };
  struct Row {
    std::string group;
    std::string title;
    Size3 size{0};
    glm::dvec3 spacing_mm{1};

    // ChainMail, of all drags.
    std::int64_t elements_moved = 0;
    std::int64_t violated_links = 0;  // 0 where a start was made without it
    double drag_seconds = 0.0;
    bool clamped = false;

    std::int64_t free_elements = 0;
    std::int64_t iterations = 0;
    double relax_seconds = 0.0;  // with its set-up
    bool converged = false;      // as relaxation says
    bool no_nearer = false;
    std::string failure;  // relaxation gave up: why

    bool finite = true;  // every displacement and every number of the progress, in every state
    double energy_first = 0.0;  // stiffness * mm^2, of springs and corners near folding
    double energy_last = 0.0;
    std::int64_t energy_rises = 0;        // from a state to the next, beyond the rounding of floats
    double largest_rise = 0.0;            // of these, as a share of the energy before
    bool energy_said_to_rise = false;     // by relaxation itself
    double largest_unrounded_rise = 0.0;  // of the lattice in fixed point: rounding, mostly

    std::int64_t folded_first = 0;
    std::int64_t folded_last = 0;
    std::int64_t folded_most = 0;
    std::int64_t newly_folded = 0;  // in any state, of cells that were not at the start

    double estimate_voxels = 0.0;  // of the largest distance, by relaxation itself; may be infinite
    double distance_voxels = 0.0;  // the largest, to the reference's equilibrium
    double distance_rms_voxels = 0.0;
    double float_step_voxels = 0.0;  // between two floats at the largest displacement
    bool reference_converged = true;
    bool reference_stable = true;  // its equilibrium is a minimum

    std::string fault(double tolerance_voxels) const;  // what of the promise is broken; empty: none
    bool is_near(double tolerance_voxels) const;       // the reference, or there is none
    Verdict verdict(double tolerance_voxels) const;
  };
  Machine machine;
  std::uint64_t seed = 1;
  int threads = 2;
  double tolerance_voxels = 0.01;
  std::vector<Row> rows;

  std::int64_t count(Verdict verdict) const;
  std::string summary() const;  // one line
};

// Errors: as a drag, a cut and a carve.
Result<StabilityReport> measure_stability(const StabilityOptions& options);

}  // namespace maille
