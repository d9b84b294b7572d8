// ChainMail by several orders of work on the same drags: how long each takes, and what is wrong
// with what it answers.
//
// Three distances tell how good a ChainMail answer is: links outside their limits (what the method
// promises not to have), the distance to the exact answer (by plain Dijkstra, the unique least
// movement), and the distance to the equilibrium that relaxation leads to from there, known as well
// as the relaxation's own estimate says.
#pragma once

#include <cstdint>
#include <functional>
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
  double relaxed_within_voxels = 0.001;
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
  // The exact answer relaxed by the product until it has converged, or comes no nearer.
  struct Relaxed {
    std::int64_t iterations = 0;
    bool converged = false;
    double residual_voxels = 0.0;  // estimated distance still to go, the largest
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
