// Ways to keep cells from folding while springs relax all the way, on the same drags: how far from
// the springs' own equilibrium each ends, how many cells fold, how long it takes. What the
// product's choice of rule, reach, weight and blend stands on.
//
// All of it in the reference code, in double precision: a way is judged by where it ends, and by
// the work in steps; its time here is not the product's.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "references/dense_springs.h"

namespace maille {

// Limits as springs of 1, 4 and 16 k; the barrier at reaches of 0.1, 0.2, 0.3 and weights of 0.1,
// 1, 10 about the middle one, and the product's own energy.
std::vector<FoldTerm> default_energies();

struct FoldStudyOptions {
  int ball_radius = 4;  // of the handle; the volume is a cube of six times that
  std::vector<double> scene_blends{0.0, 0.25, 0.5};  // of the drag in one material
  std::vector<FoldTerm> energies = default_energies();
  std::vector<double> blends{0.0, 0.125, 0.25, 0.5};  // for their own sake
  int most_newton_steps = 60;
  int most_sweeps = 1000;
  std::function<void(const std::string&)> progress = [](const std::string&) {};
};

struct FoldStudy {
  struct Way {
    std::string name;  // for a program
    std::string title;
    // From the equilibrium of the springs alone, that Newton's method finds from the same start.
    // Where that one is folded there may be others.
    double rms_voxels = 0.0;
    double max_voxels = 0.0;
    std::int64_t folded_cells = 0;
    double least_determinant = 0.0;
    double energy_excess = 0.0;    // of the springs alone, of what the start has above the
                                   // equilibrium; below 0: a lower minimum than that one
    std::int64_t steps = 0;        // Newton's, or sweeps
    std::int64_t inner_steps = 0;  // of conjugate gradients
    double seconds = 0.0;
    bool finished = false;  // at its equilibrium, or still
  };
  struct Scene {
    std::string name;
    std::string title;
    double blend = 0.0;
    std::int64_t free_elements = 0;
    std::int64_t folded_at_start = 0;
    double start_rms_voxels = 0.0;
    double start_max_voxels = 0.0;
    std::vector<Way> ways;
  };
  // What a blend costs and buys.
  struct Blend {
    double blend = 0.0;
    std::int64_t folded_cells = 0;  // a ball's drag in one material, no rule
    bool converged = false;
    bool stable = false;
    // How far apart the equilibria of three starts end (no rule): ChainMail by one stroke, by a
    // detour of two, and rest with only the handle moved.
    double detour_apart_voxels = 0.0;
    double rest_apart_voxels = 0.0;
    std::int64_t rest_folded_cells = 0;
    // And with the barrier at its defaults, from the two ChainMail starts.
    double guarded_detour_apart_voxels = 0.0;
    std::int64_t guarded_folded_cells = 0;
    // A ball 1000 times stiffer in a medium sheared by 0.3: how far it turns, of the half of the
    // shear that a rigid ball would.
    double ball_turn = 0.0;
    double ball_turn_blend_in_soft = 0.0;  // the ball's own springs with a thousandth of the blend
    double seconds = 0.0;
  };
  std::vector<Scene> scenes;
  std::vector<Blend> blends;
};

FoldStudy study_folds(const FoldStudyOptions& options, WorkerPool& pool);

}  // namespace maille
