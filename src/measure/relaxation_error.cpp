#include "measure/relaxation_error.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/stopwatch.h"
#include "measure/spring_scene.h"
#include "measure/timing.h"
#include "references/dense_checks.h"
#include "references/paper_relaxation.h"
#include "references/spring_equilibrium.h"

namespace maille {
namespace {

using Curve = RelaxationError::Curve;
using Sample = RelaxationError::Sample;

// Between two samples the clock goes on by at least this part.
constexpr double kBetweenSamples = 0.05;

// The paper's: at rest in one material a step of 2.5 still goes well, but not under compression.
constexpr double kPaperAlpha = 1.9;
constexpr double kPaperEpsilon_voxels = 0.01;

// What a state is held against.
class Judge {
 public:
  Judge(const SpringProblem& problem, const Equilibrium& equilibrium, WorkerPool& pool)
      : problem_(problem), equilibrium_(equilibrium), springs_(problem, pool) {
    for (std::size_t i = 0; i < springs_.count(); ++i) free_.push_back(!springs_.held(i));
    start_energy_ = springs_.energy(mm_of(problem.start_voxels, problem.spacing_mm));
  }

  std::int64_t free_elements() const { return springs_.free_elements(); }

  Sample sample(const DisplacementField& u_voxels) const {
    Sample sample;
    const FieldDistance distance = distance_between(u_voxels, equilibrium_.u_voxels, free_);
    sample.rms_voxels = distance.rms_voxels;
    sample.max_voxels = distance.max_voxels;
    const double above = start_energy_ - equilibrium_.energy;
    if (above > 0.0) {
      sample.energy_excess =
          (springs_.energy(mm_of(u_voxels, problem_.spacing_mm)) - equilibrium_.energy) / above;
    }
    sample.folded_cells = dense_folded_cells(problem_.size, u_voxels);
    return sample;
  }

 private:
  const SpringProblem& problem_;
  const Equilibrium& equilibrium_;
  DenseSprings springs_;
  std::vector<std::uint8_t> free_;
  double start_energy_ = 0.0;
};

// Runs a solver to its end or to most_seconds of its own time.
template <class Make>
Curve run_judged(Make&& make, const Judge& judge, double most_seconds) {
  Curve curve;
  Stopwatch clock;
  auto solver = make();
  curve.setup_seconds = clock.seconds();
  double before = curve.setup_seconds;  // this much was on the clock when it last stood still
  double next = 0.0;
  const auto take = [&](double seconds) {
    Sample sample = judge.sample(solver.displacements_voxels());
    sample.seconds = seconds;
    sample.iterations = solver.iterations();
    sample.estimate_voxels = solver.estimate_voxels();
    curve.samples.push_back(sample);
    next = seconds * (1.0 + kBetweenSamples);
  };
  take(before);
  while (!solver.finished() && before < most_seconds) {
    const Stopwatch since;
    solver.iterate();
    before += since.seconds();
    if (before >= next || solver.finished() || before >= most_seconds) take(before);
  }
  curve.finished = solver.finished();
  return curve;
}

// The times of the same iterations in another run.
template <class Make>
std::vector<double> run_timed(Make&& make, const Curve& judged) {
  std::vector<double> seconds;
  const Stopwatch clock;
  auto solver = make();
  for (const Sample& sample : judged.samples) {
    while (solver.iterations() < sample.iterations) solver.iterate();
    seconds.push_back(clock.seconds());
  }
  return seconds;
}

template <class Make>
Curve measure_curve(Make&& make, const Judge& judge, double most_seconds, int runs) {
  Curve curve = run_judged(make, judge, most_seconds);
  std::vector<std::vector<double>> seconds(curve.samples.size());
  for (std::size_t s = 0; s < seconds.size(); ++s) seconds[s] = {curve.samples[s].seconds};
  const double last = curve.samples.back().seconds;
  for (int run = 1; run < runs && (run + 1) * last <= most_seconds; ++run) {
    const auto times = run_timed(make, curve);
    for (std::size_t s = 0; s < seconds.size(); ++s) seconds[s].push_back(times[s]);
  }
  for (std::size_t s = 0; s < seconds.size(); ++s) {
    curve.samples[s].seconds = timing_of(seconds[s]).median_seconds;
  }
  curve.setup_seconds = curve.samples.front().seconds;
  for (const Sample& sample : curve.samples) {
    curve.most_folded_cells = std::max(curve.most_folded_cells, sample.folded_cells);
    for (std::size_t t = 0; t < RelaxationError::kTargets_voxels.size(); ++t) {
      const double target = RelaxationError::kTargets_voxels[t];
      if (!curve.seconds_to_rms[t] && sample.rms_voxels <= target) {
        curve.seconds_to_rms[t] = sample.seconds;
      }
      if (!curve.seconds_to_max[t] && sample.max_voxels <= target) {
        curve.seconds_to_max[t] = sample.seconds;
      }
      if (!curve.claims[t] && sample.estimate_voxels && *sample.estimate_voxels <= target) {
        curve.claims[t] = {*sample.estimate_voxels, sample.max_voxels};
      }
    }
  }
  return curve;
}

class ProductSolver {
 public:
  ProductSolver(const Deformer& deformer, WorkerPool& pool, const RelaxationOptions& options)
      : relaxation_(deformer.relax(pool, options)) {}

  void iterate() { relaxation_.iterate(); }
  bool finished() const { return relaxation_.progress().finished(); }
  std::int64_t iterations() const { return relaxation_.progress().iterations; }
  DisplacementField displacements_voxels() const { return relaxation_.displacements_voxels(); }
  std::optional<double> estimate_voxels() const {
    const double estimate = relaxation_.progress().residual_voxels;
    return std::isfinite(estimate) ? std::optional(estimate) : std::nullopt;
  }

 private:
  Relaxation relaxation_;
};

class PaperSolver {
 public:
  PaperSolver(const SpringProblem& problem, WorkerPool& pool, double epsilon_voxels)
      : relaxation_(problem, moved(problem), pool, {kPaperAlpha, epsilon_voxels}) {}

  void iterate() { relaxation_.iterate(); }
  bool finished() const { return relaxation_.finished(); }
  std::int64_t iterations() const { return relaxation_.iterations(); }
  DisplacementField displacements_voxels() const { return relaxation_.displacements_voxels(); }
  std::optional<double> estimate_voxels() const { return std::nullopt; }

 private:
  static std::vector<std::uint8_t> moved(const SpringProblem& problem) {
    std::vector<std::uint8_t> flags;
    for (const glm::dvec3& u : problem.start_voxels) flags.push_back(u != glm::dvec3(0));
    return flags;
  }
  PaperRelaxation<float> relaxation_;
};

Result<RelaxationError::Scene> measure_scene(const RelaxationScene& scene,
                                             const RelaxationErrorOptions& options,
                                             WorkerPool& pool) {
  const DragScene& drag = scene.drag;
  RelaxationError::Scene out;
  out.name = drag.name;
  out.title = drag.title;
  out.size = drag.volume.size();
  out.elements = voxel_count(out.size);
  const std::string here = drag.title + ", " + std::to_string(out.elements) + " elements: ";

  Deformer deformer(drag.volume, std::move(MaterialTable::create(drag.materials)).value(),
                    scene.anchors);
  if (auto begun = deformer.begin_stroke(drag.grab.element, drag.grab.radius_voxels); !begun) {
    return begun.error();
  }
  const auto report = deformer.drag_to(drag.grab.by_voxels, pool);
  if (!report) return report.error();
  deformer.end_stroke();
  out.moved_voxels = (*report).moved_by_voxels;

  RelaxationOptions product;
  product.tolerance_voxels = options.tolerance_voxels;
  SpringProblem problem = spring_problem_of(deformer, std::span(&drag.grab, 1), scene.anchors);
  problem.fold = kRelaxationFold;
  out.folded_at_start = dense_folded_cells(problem.size, problem.start_voxels);

  options.progress(here + "the product's end");
  SpringProblem from_there = problem;
  {
    ProductSolver solver(deformer, pool, product);
    const Stopwatch clock;
    while (!solver.finished() && clock.seconds() < options.most_seconds) solver.iterate();
    from_there.start_voxels = solver.displacements_voxels();
  }
  // Held elements lie where they lay, to the bit.
  for (std::size_t i = 0; i < problem.held.size(); ++i) {
    if (problem.held[i]) from_there.start_voxels[i] = problem.start_voxels[i];
  }
  options.progress(here + "the equilibrium");
  const Equilibrium equilibrium = spring_equilibrium(from_there, pool, options.equilibrium);
  from_there = {};
  out.equilibrium_converged = equilibrium.converged;
  out.equilibrium_stable = equilibrium.stable;
  out.equilibrium_distance_voxels = equilibrium.distance_voxels;
  out.equilibrium_folded_cells = dense_folded_cells(problem.size, equilibrium.u_voxels);
  out.equilibrium_seconds = equilibrium.seconds;

  const Judge judge(problem, equilibrium, pool);
  out.free_elements = judge.free_elements();
  const Sample start = judge.sample(problem.start_voxels);
  out.start_rms_voxels = start.rms_voxels;
  out.start_max_voxels = start.max_voxels;

  const auto add = [&](std::string solver, int threads, Curve curve) {
    curve.solver = std::move(solver);
    curve.threads = threads;
    out.curves.push_back(std::move(curve));
  };
  for (const int threads : options.threads) {
    options.progress(here + "Maille, " + std::to_string(threads) + " threads");
    WorkerPool workers(threads);
    add("product", threads,
        measure_curve([&] { return ProductSolver(deformer, workers, product); }, judge,
                      options.most_seconds, options.runs));
  }
  // It is far slower: one run tells.
  options.progress(here + "the paper's Jacobi");
  add("paper", 1,
      measure_curve([&] { return PaperSolver(problem, pool, 0.0); }, judge, options.most_seconds,
                    1));
  options.progress(here + "the paper's list");
  add("paper_list", 1,
      measure_curve([&] { return PaperSolver(problem, pool, kPaperEpsilon_voxels); }, judge,
                    options.most_seconds, 1));
  return out;
}

}  // namespace

Result<RelaxationError> measure_relaxation_error(const RelaxationErrorOptions& options) {
  RelaxationError report;
  report.seed = options.seed;
  report.runs = options.runs;
  options.progress("memory bandwidth");
  report.machine = this_machine(options.threads);
  WorkerPool pool(*std::max_element(options.threads.begin(), options.threads.end()));
  for (const std::int64_t elements : options.elements) {
    auto nose = nose_relaxation(elements, options.seed, options.head, pool);
    if (!nose) return nose.error();
    std::vector<RelaxationScene> scenes;
    scenes.push_back(homogeneous_relaxation(elements));
    scenes.push_back(stiff_ball_relaxation(elements));
    scenes.push_back(random_relaxation(elements, options.seed));
    scenes.push_back(sheet_relaxation(elements));
    scenes.push_back(*std::move(nose));
    for (const RelaxationScene& scene : scenes) {
      auto measured = measure_scene(scene, options, pool);
      if (!measured) return measured.error();
      report.scenes.push_back(*std::move(measured));
    }
  }
  report.folds = study_folds(options.folds, pool);
  return report;
}

}  // namespace maille
