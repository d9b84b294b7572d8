// ChainMail by several orders of work on the same drags: how long each takes, and what is wrong
// with what it answers.
//
// Three distances tell how good a ChainMail answer is: links outside their limits (what the method
// promises not to have), the distance to the exact answer (by plain Dijkstra, the unique least
// movement), and the distance to the state that relaxation leads to from there. That state is an
// equilibrium only where relaxation converged: elsewhere it comes with the relaxation's own
// estimate of how far it still is.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "measure/drag_scene.h"
#include "measure/machine.h"
#include "measure/timing.h"

namespace maille {

struct ChainMailErrorOptions {
  std::vector<int> threads{1, 2};  // for the product's solver; the references have one
  int runs = 7;                    // of the product, of which the median counts
  int reference_runs = 3;          // they take seconds
  int edge = 64;                   // of the cubes with made-up materials, voxels
  int head_edge = 128;
  std::int64_t relaxation_iterations = 1000;  // at most; the plain relaxation needs thousands
  std::uint64_t seed = 1;
  std::function<void(const std::string&)> progress = [](const std::string&) {};
};

struct ChainMailError {
  struct Order {
    std::string name;  // "exact", "heap", "fifo" or "dijkstra"
    int threads = 1;
    Timing timing;
    std::int64_t elements_moved = 0;
    std::int64_t violated_links = 0;
    double worst_violation_voxels = 0.0;
    std::int64_t folded_cells = 0;
    // Over the elements that any of the scene's orders moved.
    double rms_to_exact_voxels = 0.0;
    double max_to_exact_voxels = 0.0;
    double rms_to_relaxed_voxels = 0.0;
    double max_to_relaxed_voxels = 0.0;
  };
  // The exact answer relaxed by the product, as far as it got.
  struct Relaxed {
    std::int64_t iterations = 0;
    bool converged = false;
    std::optional<double> residual_voxels;  // estimated distance still to go, where it is known
    std::int64_t folded_cells = 0;
    double seconds = 0.0;
  };
  struct Scene {
    std::string name;
    std::string title;
    Size3 size{0};
    glm::dvec3 asked_voxels{0};  // the drag
    glm::dvec3 moved_voxels{0};  // less than asked where an anchor held it; all orders are given
                                 // this, since the references know no such thing
    std::int64_t affected_elements = 0;  // that any order moved
    std::int64_t affected_links = 0;     // with such an element at one end or both
    Relaxed relaxed;
    std::vector<Order> orders;
  };
  Machine machine;
  std::uint64_t seed = 1;
  std::vector<Scene> scenes;
};

// Errors: as make_phantom for the head.
Result<ChainMailError> measure_chainmail_error(const ChainMailErrorOptions& options);

}  // namespace maille
