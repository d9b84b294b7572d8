#include "measure/chainmail_error.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/stopwatch.h"
#include "references/dense_checks.h"
#include "references/enhanced_chainmail.h"
#include "references/exact_dijkstra.h"
#include "references/fifo_chainmail.h"

namespace maille {
namespace {

using Displacements = std::vector<glm::ivec3>;

// The drag of the design's table.
constexpr glm::dvec3 kDrag_voxels{14.0, 6.0, -3.0};

Result<std::vector<DragScene>> scenes_of(const ChainMailErrorOptions& options, WorkerPool& pool) {
  const int edge = options.edge;
  const glm::dvec3 by = kDrag_voxels * (edge / 96.0);
  std::vector<DragScene> scenes;
  scenes.push_back(random_scene(edge, edge, {soft_and_stiff()[0]}, options.seed, by));
  scenes.back().name = "one_material";
  scenes.back().title = "one material";
  scenes.push_back(stiff_ball_scene(edge, by));
  scenes.push_back(random_scene(edge, 1, three_tissues(), options.seed, by));
  scenes.push_back(anisotropic_scene(edge, by));
  scenes.push_back(random_scene(edge, 8, three_tissues(), options.seed, by));
  scenes.back().name = "second_grab";
  scenes.back().title = "3 materials in random 8³ blocks, a second grab";
  scenes.back().before = {
      {VoxelIndex(edge / 3, edge / 2, edge / 2), 0.0, glm::dvec3(-0.6, 1.0, 0.5) * (edge / 12.0)}};
  auto head = head_scene(options.head_edge, options.seed, pool);
  if (!head) return head.error();
  scenes.push_back(*std::move(head));
  return scenes;
}

Displacements dense(const Lattice& lattice) {
  const Size3 size = lattice.grid().volume_size();
  Displacements u;
  u.reserve(static_cast<std::size_t>(voxel_count(size)));
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) u.push_back(lattice.u({x, y, z}));
    }
  }
  return u;
}

std::vector<VoxelIndex> movable_ball(const Grab& grab, const DenseProblem& problem) {
  std::vector<VoxelIndex> ball;
  const VoxelIndex reach(static_cast<int>(grab.radius_voxels));
  const VoxelIndex lo = glm::max(grab.element - reach, VoxelIndex(0));
  const VoxelIndex hi = glm::min(grab.element + reach, problem.size - 1);
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x) {
        const glm::dvec3 away = glm::dvec3(x, y, z) - glm::dvec3(grab.element);
        const MaterialId id = problem.ids[element_of({x, y, z}, problem.size)];
        if (glm::dot(away, away) <= grab.radius_voxels * grab.radius_voxels &&
            !problem.materials[id].fixed) {
          ball.emplace_back(x, y, z);
        }
      }
    }
  }
  return ball;
}

// An answer and how long it took.
struct Run {
  std::string order;
  int threads = 1;
  Timing timing;
  Displacements u;
};

// Leaves the last stroke on: relaxation goes on from there.
Result<Run> run_product(Deformer& deformer, const DragScene& scene, int threads, int runs) {
  WorkerPool pool(threads);
  std::vector<double> seconds;
  for (int run = 0; run < runs; ++run) {
    deformer.cancel_stroke();
    if (auto begun = deformer.begin_stroke(scene.grab.element, scene.grab.radius_voxels); !begun) {
      return begun.error();
    }
    const auto drag = timed_drag(deformer, scene.grab.by_voxels, pool);
    if (!drag) return drag.error();
    seconds.push_back((*drag).seconds);
  }
  return Run{"exact", threads, timing_of(std::move(seconds)), dense(deformer.lattice())};
}

template <class Solve>
Run run_reference(std::string order, const DenseProblem& problem, int runs, Solve&& solve) {
  std::vector<double> seconds;
  DenseAnswer answer;
  for (int run = 0; run < runs; ++run) {
    const Stopwatch start;
    answer = solve(problem);
    seconds.push_back(start.seconds());
  }
  return {std::move(order), 1, timing_of(std::move(seconds)), std::move(answer.u)};
}

struct Distance {
  double rms_voxels = 0.0;
  double max_voxels = 0.0;
};

Distance distance(const Displacements& a, const Displacements& b,
                  const std::vector<std::uint8_t>& counted) {
  double sum = 0.0;
  double most = 0.0;
  std::int64_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!counted[i]) continue;
    const glm::dvec3 apart = glm::dvec3(a[i] - b[i]);
    const double squared = glm::dot(apart, apart);
    sum += squared;
    most = std::max(most, squared);
    ++count;
  }
  if (count == 0) return {};
  return {std::sqrt(sum / static_cast<double>(count)) / kUnitsPerVoxel,
          std::sqrt(most) / kUnitsPerVoxel};
}

ChainMailError::Relaxed relax(Deformer& deformer, const ChainMailErrorOptions& options,
                              WorkerPool& pool, Displacements& u) {
  ChainMailError::Relaxed relaxed;
  const Stopwatch start;
  RelaxationOptions to_equilibrium;
  to_equilibrium.tolerance_voxels = options.relaxed_within_voxels;
  Relaxation relaxation = deformer.relax(pool, to_equilibrium);
  while (!relaxation.progress().finished()) relaxation.iterate();
  relaxed.seconds = start.seconds();
  const RelaxationProgress& progress = relaxation.progress();
  relaxed.iterations = progress.iterations;
  relaxed.converged = progress.converged;
  relaxed.residual_voxels = progress.residual_voxels;
  u = dense(relaxation.lattice());
  relaxed.folded_cells = dense_folded_cells(deformer.lattice().grid().volume_size(), u);
  return relaxed;
}

Result<ChainMailError::Scene> measure_scene(const DragScene& scene,
                                            const ChainMailErrorOptions& options,
                                            WorkerPool& pool) {
  const Size3 size = scene.volume.size();
  ChainMailError::Scene out;
  out.name = scene.name;
  out.title = scene.title;
  out.size = size;
  out.asked_voxels = scene.grab.by_voxels;

  Deformer deformer = scene.deformer();
  if (auto played = scene.play_before(deformer, pool); !played) return played.error();

  DenseProblem problem;
  problem.size = size;
  problem.materials = deformer.materials().table().materials();
  problem.ids.resize(static_cast<std::size_t>(voxel_count(size)));
  deformer.materials().read({VoxelIndex(0), size}, problem.ids);
  problem.start = dense(deformer.lattice());
  problem.handle = movable_ball(scene.grab, problem);
  problem.by = glm::ivec3(glm::round(scene.grab.by_voxels * double{kUnitsPerVoxel}));

  std::vector<Run> runs;
  for (const int threads : options.threads) {
    options.progress(scene.title + ": exact, " + std::to_string(threads) + " threads");
    auto run = run_product(deformer, scene, threads, options.runs);
    if (!run) return run.error();
    runs.push_back(*std::move(run));
  }
  options.progress(scene.title + ": Dijkstra");
  glm::ivec3 moved_by{0};
  runs.push_back(
      run_reference("dijkstra", problem, options.reference_runs, [&](const DenseProblem& p) {
        DenseAnswer answer = exact_dijkstra(p);
        moved_by = answer.moved_by;
        return answer;
      }));
  const Displacements exact = runs.back().u;
  out.moved_voxels = glm::dvec3(moved_by) / double{kUnitsPerVoxel};
  problem.by = moved_by;
  options.progress(scene.title + ": heap");
  runs.push_back(run_reference("heap", problem, options.reference_runs, enhanced_chainmail));
  options.progress(scene.title + ": FIFO");
  runs.push_back(run_reference("fifo", problem, options.reference_runs, fifo_chainmail));

  options.progress(scene.title + ": relaxation");
  Displacements relaxed;
  out.relaxed = relax(deformer, options, pool, relaxed);

  std::vector<std::uint8_t> affected(problem.ids.size(), 0);
  for (const Run& run : runs) {
    for (std::size_t i = 0; i < affected.size(); ++i) affected[i] |= run.u[i] != problem.start[i];
  }
  for (std::size_t i = 0; i < affected.size(); ++i) {
    out.affected_elements += affected[i];
    for_each_neighbour(i, size, [&](std::size_t j, int, int side) {
      out.affected_links += side > 0 && (affected[i] || affected[j]);
    });
  }
  for (const Run& run : runs) {
    ChainMailError::Order order;
    order.name = run.order;
    order.threads = run.threads;
    order.timing = run.timing;
    for (std::size_t i = 0; i < affected.size(); ++i) {
      order.elements_moved += run.u[i] != problem.start[i];
    }
    const DenseViolations violations = dense_violations(problem, run.u);
    order.violated_links = violations.links;
    order.worst_violation_voxels = violations.worst_voxels;
    order.folded_cells = dense_folded_cells(size, run.u);
    const Distance to_exact = distance(run.u, exact, affected);
    order.rms_to_exact_voxels = to_exact.rms_voxels;
    order.max_to_exact_voxels = to_exact.max_voxels;
    const Distance to_relaxed = distance(run.u, relaxed, affected);
    order.rms_to_relaxed_voxels = to_relaxed.rms_voxels;
    order.max_to_relaxed_voxels = to_relaxed.max_voxels;
    out.orders.push_back(std::move(order));
  }
  return out;
}

}  // namespace

Result<ChainMailError> measure_chainmail_error(const ChainMailErrorOptions& options) {
  ChainMailError report;
  report.seed = options.seed;
  options.progress("memory bandwidth");
  report.machine = this_machine(options.threads);
  WorkerPool pool(*std::max_element(options.threads.begin(), options.threads.end()));
  auto scenes = scenes_of(options, pool);
  if (!scenes) return scenes.error();
  for (const DragScene& scene : *scenes) {
    auto measured = measure_scene(scene, options, pool);
    if (!measured) return measured.error();
    report.scenes.push_back(*std::move(measured));
  }
  return report;
}

}  // namespace maille
