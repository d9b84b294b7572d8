#include "measure/stability.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/failure.h"
#include "core/stopwatch.h"
#include "measure/spring_scene.h"
#include "measure/stability_case.h"
#include "measure/text_table.h"
#include "references/dense_checks.h"
#include "references/spring_equilibrium.h"

namespace maille {
namespace {

using Row = StabilityReport::Row;
using Verdict = StabilityReport::Verdict;

// Relaxation tells energies from floats: they change one by about this share, and where energy
// falls by many decades by this share of what there was.
constexpr double kEnergyRounding = 1e-6;
constexpr double kFirstEnergyRounding = 1e-10;

// Relaxation's rule against folding, as the issue of it has it; written down here again.
constexpr FoldTerm kFoldRule = kRelaxationFold;

std::vector<glm::ivec3> fixed_point(const Lattice& lattice) {
  const Size3 size = lattice.grid().volume_size();
  std::vector<glm::ivec3> u;
  u.reserve(static_cast<std::size_t>(voxel_count(size)));
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) u.push_back(lattice.u({x, y, z}));
    }
  }
  return u;
}

Lattice lattice_of(Size3 size, const std::vector<glm::ivec3>& u) {
  Lattice lattice(size);
  const BrickGrid& grid = lattice.grid();
  for (std::int64_t b = 0; b < grid.count(); ++b) {
    auto brick = std::make_unique<BrickDisplacements>();
    const VoxelBox box = grid.box(grid.brick(b));
    for (int z = box.lo.z; z < box.hi.z; ++z) {
      for (int y = box.lo.y; y < box.hi.y; ++y) {
        for (int x = box.lo.x; x < box.hi.x; ++x) {
          const VoxelIndex v(x, y, z);
          for (int c = 0; c < 3; ++c) {
            brick->u[c][element_in_brick(v)] =
                u[static_cast<std::size_t>(linear_index(v, size))][c];
          }
        }
      }
    }
    lattice.set(b, LatticeBrick::create(box, *brick));
  }
  return lattice;
}

// What hangs together with nothing that is held stays where it is, as relaxation has it: alone it
// would have no one equilibrium.
void hold_loose_pieces(SpringProblem& problem, WorkerPool& pool) {
  const DenseSprings springs(problem, pool);
  std::vector<std::uint8_t> reached(problem.held.size(), 0);
  std::vector<std::size_t> ahead;
  const auto reach = [&](std::size_t i) {
    if (reached[i]) return;
    reached[i] = 1;
    ahead.push_back(i);
  };
  for (std::size_t i = 0; i < reached.size(); ++i) {
    if (problem.held[i]) reach(i);
  }
  while (!ahead.empty()) {
    const std::size_t i = ahead.back();
    ahead.pop_back();
    springs.for_each_spring_of(i,
                               [&](std::size_t j, const DenseSprings::SpringView&) { reach(j); });
  }
  for (std::size_t i = 0; i < reached.size(); ++i) problem.held[i] |= !reached[i];
}

Result<void> drag(const StabilityCase& asked, Deformer& deformer, WorkerPool& pool, Row& row) {
  if (asked.before) {
    if (auto done = asked.before(deformer); !done) return done;
  }
  for (const Grab& grab : asked.grabs) {
    if (auto begun = deformer.begin_stroke(grab.element, grab.radius_voxels); !begun) return begun;
    const auto dragged = timed_drag(deformer, grab.by_voxels, pool);
    if (!dragged) return dragged.error();
    row.drag_seconds += (*dragged).seconds;
    row.elements_moved = std::max(row.elements_moved, (*dragged).report.elements_moved);
    row.clamped = row.clamped || (*dragged).report.clamped;
    deformer.end_stroke();
  }
  if (!asked.start.empty()) deformer.adopt(lattice_of(asked.volume.size(), asked.start));
  return {};
}

// Looks at each state as it comes and keeps what was worst.
class Watch {
 public:
  Watch(const SpringProblem& problem, WorkerPool& pool, Row& row)
      : problem_(problem), springs_(problem, pool), row_(row) {
    row_.free_elements = springs_.free_elements();
  }

  // The lattice is what is shown; u_voxels the state of the solver, which may have gone on to one
  // that is not.
  void look(const Lattice& lattice, DisplacementField u_voxels) {
    for (const glm::dvec3& u : u_voxels) {
      row_.finite = row_.finite && std::isfinite(u.x + u.y + u.z);
    }
    const auto u = fixed_point(lattice);
    if (!row_.finite || !rounds_to(u_voxels, u)) return;
    u_voxels_ = std::move(u_voxels);
    look_at_energy(displacements_of(lattice));
    look_at_folds(u);
    first_ = false;
  }
  // Of the last state that was shown, unrounded.
  const DisplacementField& last() const { return u_voxels_; }

 private:
  static bool rounds_to(const DisplacementField& u_voxels, const std::vector<glm::ivec3>& u) {
    for (std::size_t i = 0; i < u.size(); ++i) {
      const glm::dvec3 exact = u_voxels[i] * double{kUnitsPerVoxel};
      const glm::dvec3 off = glm::abs(exact - glm::dvec3(u[i]));
      // A unit where rounding minds the energy, half of one elsewhere, and what a float leaves
      // open.
      const glm::dvec3 most = 1.001 + 1e-6 * glm::abs(exact);
      if (glm::any(glm::greaterThan(off, most))) return false;
    }
    return true;
  }

  double energy_of(const DisplacementField& u_voxels) const {
    return springs_.energy(mm_of(u_voxels, problem_.spacing_mm));
  }

  void look_at_energy(const DisplacementField& rounded_voxels) {
    const double energy = energy_of(u_voxels_);
    const double published = energy_of(rounded_voxels);
    row_.finite = row_.finite && std::isfinite(energy);
    row_.finite = row_.finite && std::isfinite(published);
    if (first_) {
      row_.energy_first = published;
    } else {
      const double rise = published - row_.energy_last;
      if (rise > kEnergyRounding * row_.energy_last + kFirstEnergyRounding * row_.energy_first) {
        ++row_.energy_rises;
        row_.largest_rise = std::max(row_.largest_rise, rise / row_.energy_last);
      }
      if (energy > unrounded_ && unrounded_ > 0.0) {
        row_.largest_unrounded_rise =
            std::max(row_.largest_unrounded_rise, energy / unrounded_ - 1.0);
      }
    }
    row_.energy_last = published;
    unrounded_ = energy;
  }

  void look_at_folds(const std::vector<glm::ivec3>& u) {
    const auto folded = dense_folds(problem_.size, u, problem_.removed);
    std::int64_t count = 0;
    std::int64_t fresh = 0;
    for (std::size_t i = 0; i < folded.size(); ++i) {
      count += folded[i];
      fresh += !first_ && folded[i] && !folded_first_[i];
    }
    if (first_) {
      row_.folded_first = count;
      folded_first_ = folded;
    }
    row_.folded_last = count;
    row_.folded_most = std::max(row_.folded_most, count);
    row_.newly_folded = std::max(row_.newly_folded, fresh);
  }

  const SpringProblem& problem_;
  DenseSprings springs_;
  Row& row_;
  bool first_ = true;
  DisplacementField u_voxels_;
  double unrounded_ = 0.0;  // energy of the last state, before its rounding
  std::vector<std::uint8_t> folded_first_;
};

void relax(const Deformer& deformer, const StabilityOptions& options, WorkerPool& pool,
           Watch& watch, Row& row) {
  RelaxationOptions wanted;
  wanted.tolerance_voxels = options.tolerance_voxels;
  try {
    const Stopwatch set_up;
    Relaxation relaxation = deformer.relax(pool, wanted);
    row.relax_seconds = set_up.seconds();
    watch.look(relaxation.lattice(), relaxation.displacements_voxels());
    while (!relaxation.progress().finished() &&
           relaxation.progress().iterations < options.most_iterations &&
           row.relax_seconds < options.most_seconds) {
      const Stopwatch cycle;
      const RelaxationProgress& progress = relaxation.iterate();
      row.relax_seconds += cycle.seconds();
      row.finite = row.finite && std::isfinite(progress.energy_last) &&
                   !std::isnan(progress.residual_voxels) &&
                   !std::isnan(progress.residual_rms_voxels);
      watch.look(relaxation.lattice(), relaxation.displacements_voxels());
    }
    const RelaxationProgress& progress = relaxation.progress();
    row.iterations = progress.iterations;
    row.converged = progress.converged;
    row.no_nearer = progress.no_nearer;
    row.energy_said_to_rise = progress.energy_ever_rose;
    row.estimate_voxels = progress.residual_voxels;
  } catch (const Failure& failure) {
    row.failure = failure.what();
  }
}

void compare(SpringProblem& problem, DisplacementField u_voxels, WorkerPool& pool, Row& row) {
  double furthest = 0.0;
  for (const glm::dvec3& u : u_voxels) furthest = std::max(furthest, glm::length(u));
  row.float_step_voxels = furthest * double{std::numeric_limits<float>::epsilon()};
  std::vector<std::uint8_t> counted;
  for (const std::uint8_t held : problem.held) counted.push_back(!held);
  problem.start_voxels = std::move(u_voxels);
  EquilibriumOptions options;
  options.tolerance_voxels = 1e-5;
  options.most_newton_steps = 10;  // from where relaxation ended it takes three or four
  options.most_cg_steps = 300;
  const Equilibrium equilibrium = spring_equilibrium(problem, pool, options);
  row.reference_converged = equilibrium.converged;
  row.reference_stable = equilibrium.stable;
  const FieldDistance apart = distance_between(problem.start_voxels, equilibrium.u_voxels, counted);
  row.distance_voxels = apart.max_voxels;
  row.distance_rms_voxels = apart.rms_voxels;
}

Result<Row> measure_case(const StabilityCase& asked, const StabilityOptions& options,
                         WorkerPool& pool) {
  Row row;
  row.group = asked.group;
  row.title = asked.title;
  row.size = asked.volume.size();
  row.spacing_mm = asked.volume.spacing_mm();
  auto table = MaterialTable::create(asked.materials);
  if (!table) return table.error();
  Deformer deformer(asked.volume, *std::move(table), asked.anchors);
  if (auto dragged = drag(asked, deformer, pool, row); !dragged) return dragged.error();

  SpringProblem problem = spring_problem_of(deformer, asked.grabs, asked.anchors);
  problem.fold = kFoldRule;
  hold_loose_pieces(problem, pool);
  if (asked.start.empty()) {
    const auto u = fixed_point(deformer.lattice());
    DenseProblem links;
    links.size = problem.size;
    links.materials = deformer.materials().table().materials();
    links.ids = problem.ids;
    links.removed = problem.removed;
    row.violated_links = dense_violations(links, u).links;
  }
  Watch watch(problem, pool, row);
  relax(deformer, options, pool, watch, row);
  if (row.failure.empty() && row.finite) compare(problem, watch.last(), pool, row);
  return row;
}

}  // namespace

std::string Row::fault(double tolerance_voxels) const {
  std::vector<std::string> faults;
  if (!failure.empty()) faults.push_back("gave up: " + failure);
  if (!finite) faults.push_back("not finite");
  if (violated_links > 0) faults.push_back(std::to_string(violated_links) + " violated links");
  if (energy_rises > 0) faults.push_back("energy rose " + std::to_string(energy_rises) + " times");
  if (energy_said_to_rise && energy_rises == 0) faults.push_back("energy is said to have risen");
  if (folded_most > folded_first) {
    faults.push_back(std::to_string(folded_most - folded_first) + " more folded cells");
  } else if (newly_folded > 0) {
    faults.push_back(std::to_string(newly_folded) + " newly folded cells");
  }
  if (!converged && !no_nearer) faults.push_back("never ends");
  const bool says_so = no_nearer && distance_voxels <= estimate_voxels;
  if (!is_near(tolerance_voxels) && !says_so) {
    faults.push_back(fixed_number(distance_voxels, 3) + " voxels off");
  }
  std::string all;
  for (const std::string& one : faults) all += (all.empty() ? "" : ", ") + one;
  return all;
}

bool Row::is_near(double tolerance_voxels) const {
  // Nearer than floats can say where an element is nobody can end.
  const double near = std::max(tolerance_voxels, no_nearer ? 4.0 * float_step_voxels : 0.0);
  return !reference_converged || distance_voxels <= near;
}

Verdict Row::verdict(double tolerance_voxels) const {
  if (!fault(tolerance_voxels).empty()) return Verdict::fails;
  if (!is_near(tolerance_voxels)) return Verdict::says_so;
  return reference_converged ? Verdict::holds : Verdict::undecided;
}

std::int64_t StabilityReport::count(Verdict verdict) const {
  return std::count_if(rows.begin(), rows.end(),
                       [&](const Row& row) { return row.verdict(tolerance_voxels) == verdict; });
}

std::string StabilityReport::summary() const {
  const auto says_so = count(Verdict::says_so);
  const auto fails = count(Verdict::fails);
  const auto undecided = count(Verdict::undecided);
  std::string out = "holds in " + std::to_string(count(Verdict::holds)) + " of " +
                    std::to_string(rows.size()) + " cases";
  if (says_so > 0) out += ", says that it comes no nearer in " + std::to_string(says_so);
  if (fails > 0) out += ", does NOT hold in " + std::to_string(fails);
  if (undecided > 0) out += ", no reference to tell by in " + std::to_string(undecided);
  return out;
}

Result<StabilityReport> measure_stability(const StabilityOptions& options) {
  StabilityReport report;
  report.seed = options.seed;
  report.threads = options.threads;
  report.tolerance_voxels = options.tolerance_voxels;
  options.progress("memory bandwidth");
  report.machine = this_machine(std::vector<int>{options.threads});
  WorkerPool pool(options.threads);
  for (const StabilityCase& asked : stability_cases(options.edge, options.seed, options.groups)) {
    options.progress(asked.group + ": " + asked.title);
    auto row = measure_case(asked, options, pool);
    if (!row) {
      return Error{row.error().kind, asked.group + ", " + asked.title + ": " + row.error().message};
    }
    report.rows.push_back(*std::move(row));
  }
  return report;
}

}  // namespace maille
