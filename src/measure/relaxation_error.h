// Relaxation by several solvers from the same ChainMail answers: how far each is from the true
// equilibrium after so many milliseconds, set-up counted.
//
// The equilibrium is that of the reference (Newton's method in double precision), found from where
// the product's solver ends, so that where springs have several it is the one that was headed for.
// The clock stands still while distances are taken.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "measure/fold_study.h"
#include "measure/machine.h"
#include "measure/relaxation_scene.h"
#include "measure/spring_scene.h"
#include "references/spring_equilibrium.h"

namespace maille {

struct RelaxationErrorOptions {
  std::vector<int> threads{1, 2};  // for the product's solver; the paper's has one
  std::vector<std::int64_t> elements{100'000, 2'000'000};
  int runs = 5;  // of the product, of which the median counts; fewer where they would take more
                 // than most_seconds in all
  double most_seconds = 20.0;      // of one solver in one scene, on its own clock
  double tolerance_voxels = 5e-4;  // of the product's solver: it is measured until it says so
  EquilibriumOptions equilibrium;
  FoldStudyOptions folds;
  std::optional<std::filesystem::path> head;  // a scan with a nose; none: the built-in head
  std::uint64_t seed = 1;
  std::function<void(const std::string&)> progress = [](const std::string&) {};
};

struct RelaxationError {
  // What the times in the table are to.
  static constexpr std::array<double, 3> kTargets_voxels{0.1, 0.01, 0.001};

  struct Sample {
    double seconds = 0.0;  // since the solver was begun, set-up included; the median of all runs
    std::int64_t iterations = 0;
    double rms_voxels = 0.0;  // from the equilibrium, over the free elements
    double max_voxels = 0.0;
    double energy_excess = 0.0;  // of what the start has above the equilibrium
    std::int64_t folded_cells = 0;
    std::optional<double> estimate_voxels;  // the solver's own, of max_voxels; none: it has none
  };
  // When a solver first says that it is as near as this.
  struct Claim {
    double said_voxels = 0.0;  // its estimate then
    double true_voxels = 0.0;  // the largest distance then
  };
  struct Curve {
    std::string solver;  // "product", "paper" or "paper_list"
    int threads = 1;
    double setup_seconds = 0.0;
    bool finished = false;  // by its own word
    std::vector<Sample> samples;
    // First time at or below each target; none where it was not reached.
    std::array<std::optional<double>, 3> seconds_to_rms;
    std::array<std::optional<double>, 3> seconds_to_max;
    std::array<std::optional<Claim>, 3> claims;
    std::int64_t most_folded_cells = 0;
  };
  struct Scene {
    std::string name;
    std::string title;
    Size3 size{0};
    std::int64_t elements = 0;
    std::int64_t free_elements = 0;
    glm::dvec3 moved_voxels{0};  // the drag
    std::int64_t folded_at_start = 0;
    double start_rms_voxels = 0.0;
    double start_max_voxels = 0.0;
    // Of the reference.
    bool equilibrium_converged = false;
    bool equilibrium_stable = false;
    double equilibrium_distance_voxels = 0.0;
    std::int64_t equilibrium_folded_cells = 0;
    double equilibrium_seconds = 0.0;
    std::vector<Curve> curves;
  };
  Machine machine;
  std::uint64_t seed = 1;
  int runs = 0;
  std::vector<Scene> scenes;
  FoldStudy folds;
};

// Errors: as nose_relaxation and Deformer's drags.
Result<RelaxationError> measure_relaxation_error(const RelaxationErrorOptions& options);

}  // namespace maille
