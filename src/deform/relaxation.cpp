#include "deform/relaxation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/failure.h"
#include "core/trace.h"
#include "deform/fold_guard.h"
#include "deform/relaxation_region.h"
#include "deform/spring_box.h"
#include "deform/spring_rows.h"
#include "deform/stiffness_multigrid.h"

namespace maille {
namespace {

// What a free element takes: four vectors, flags, materials, and the coarser levels.
constexpr std::int64_t kBytesPerElement = 64;
// Energies are sums of floats: a rise beyond this share is a rise.
constexpr double kEnergyNoise = 1e-7;
constexpr double kCornersLeft = 0.1;
// Estimates that have not fallen by a tenth in so many iterations, nor the energy by this share, will
// not: far from an equilibrium estimates rise and fall while the energy only falls.
constexpr int kPatience = 12;
constexpr double kEnergyGain = 1e-4;

VoxelBox moved_box(const Lattice& lattice) {
  VoxelBox box{lattice.grid().volume_size(), VoxelIndex(0)};
  lattice.for_each_brick([&](std::int64_t, const LatticeBrick& brick) {
    box.lo = glm::min(box.lo, brick.moved().lo);
    box.hi = glm::max(box.hi, brick.moved().hi);
  });
  return box;
}

std::int64_t most_elements(std::int64_t bytes) { return std::max<std::int64_t>(1, bytes / kBytesPerElement); }

}  // namespace

struct Relaxation::State {
  const MaterialField& materials;
  Cuts cuts;
  ElementSet held;
  AnchorRules anchors;
  WorkerPool& pool;
  RelaxationOptions options;
  RelaxationProgress progress;
  RelaxationRegion region;
  Lattice published;

  // Of one region.
  struct Solver {
    SpringBox box;
    StiffnessMultigrid multigrid;
    FoldGuard guard;
    BoxVectors forces;
    BoxVectors moves;      // what multigrid makes of them
    BoxVectors direction;  // of the next step
    double step = 0.0;
    double furthest_voxels = 0.0;   // of a step of 1
    double moves_dot_forces = 0.0;
    double caution = 1.0;  // share of the step that is taken

    Solver(const SpringBox::Problem& problem, const VoxelBox& free, WorkerPool& pool)
        : box(problem, free, pool),
          multigrid(box, pool),
          guard(box, pool),
          forces(make_box_vectors(box.extent(), pool)),
          moves(make_box_vectors(box.extent(), pool)),
          direction(make_box_vectors(box.extent(), pool)) {}

    std::int64_t bytes() const {
      return box.bytes() + multigrid.bytes() + bytes_of(forces) + bytes_of(moves) +
             bytes_of(direction);
    }
  };
  std::unique_ptr<Solver> solver;
  double best_residual = std::numeric_limits<double>::infinity();
  double best_energy = std::numeric_limits<double>::infinity();
  int iterations_without_gain = 0;
  bool unpublished = false;

  State(const Lattice& start, const MaterialField& field, const Cuts& gone,
        const ElementSet& holds, AnchorRules rules, WorkerPool& workers,
        const RelaxationOptions& wanted, const std::optional<VoxelBox>& disturbed)
      : materials(field),
        cuts(gone),
        held(holds),
        anchors(rules),
        pool(workers),
        options(wanted),
        region(disturbed.value_or(moved_box(start)), field.size(), rules,
               most_elements(wanted.memory_bytes)),
        published(start) {
    if (!region.box().empty()) begin();
    if (!solver) settle_without_work();
  }

  void settle_without_work() {
    progress.converged = true;
    progress.residual_voxels = progress.residual_rms_voxels = 0.0;
  }

  // A solver of the region as it is now, from what is published.
  void begin() {
    const trace::Span span("relaxation set-up");
    solver.reset();
    auto next = std::make_unique<Solver>(
        SpringBox::Problem{published, materials, cuts, held, anchors}, region.box(), pool);
    if (next->box.free_elements() == 0) return;
    solver = std::move(next);
    progress.free_elements = solver->box.free_elements();
    progress.region_limited = region.limited();
    aim(true);
    progress.energy_first = progress.energy_last;
  }

  // Sums over the rows of the free elements, in the order of the rows.
  template <std::size_t kSums, class F>
  std::array<double, kSums> over_rows(int margin, F&& f) {
    const Size3 extent = solver->box.extent();
    std::vector<std::array<double, kSums>> parts(static_cast<std::size_t>(extent.z));
    pool.for_each(extent.z - 2 * margin, [&](std::int64_t plane, int) {
      auto& sums = parts[static_cast<std::size_t>(plane)];
      sums.fill(0.0);
      for (int y = margin; y < extent.y - margin; ++y) {
        const std::int64_t row = solver->box.row(y, static_cast<int>(plane) + margin);
        if (margin > 0 && solver->box.kind(row) == RowKind::held) continue;
        for_each_run(solver->box, row, margin, extent.x - margin,
                     [&](const SpringRun& run) { f(run, sums); });
      }
    });
    std::array<double, kSums> total{};
    for (const auto& part : parts) {
      for (std::size_t i = 0; i < kSums; ++i) total[i] += part[i];
    }
    return total;
  }

  static double dot(const BoxVectors& a, const BoxVectors& b, const SpringRun& run) {
    double sum = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      sum += dot_of_run(&a[c][run.first], &b[c][run.first], run.count);
    }
    return sum;
  }

  // Forces of the state as it is; moves become stale.
  void compute_forces() {
    const trace::Span span("spring forces");
    Solver& s = *solver;
    static_cast<void>(over_rows<1>(1, [&](const SpringRun& run, auto&) {
      RunVectors force;
      spring_forces(s.box, run, force);
      const std::uint8_t* const free = s.box.free_flags() + run.first;
      const float* const parts[3] = {force.x, force.y, force.z};
      for (std::size_t c = 0; c < 3; ++c) {
        float* const to = &s.forces[c][run.first];
        for (int x = 0; x < run.count; ++x) to[x] = free[x] ? parts[c][x] : 0.0f;
      }
    }));
    s.guard.add_forces(s.forces);
  }

  // The direction and length of the next step, and what can be told from them.
  void aim(bool first) {
    Solver& s = *solver;
    compute_forces();
    double old_moves_dot_forces = 0.0;
    if (!first) {
      old_moves_dot_forces = over_rows<1>(1, [&](const SpringRun& run, auto& sums) {
        sums[0] += dot(s.moves, s.forces, run);
      })[0];
    }
    s.multigrid.solve(s.forces, s.moves);
    const auto now = over_rows<2>(1, [&](const SpringRun& run, auto& sums) {
      sums[0] += dot(s.moves, s.forces, run);
      sums[1] += dot(s.moves, s.moves, run);
    });
    check_finite(now[0] + now[1]);
    const double keep = first || !(s.moves_dot_forces > 0.0)
                            ? 0.0
                            : std::max(0.0, (now[0] - old_moves_dot_forces) / s.moves_dot_forces);
    s.moves_dot_forces = now[0];
    double slope = turn(static_cast<float>(keep));
    if (!(slope > 0.0) && keep > 0.0) slope = turn(0.0f);
    measure(slope, now[1], first);
  }

  // direction = moves + keep * direction; returns its dot product with the forces.
  double turn(float keep) {
    Solver& s = *solver;
    const trace::Span span("direction");
    return over_rows<1>(1, [&](const SpringRun& run, auto& sums) {
      for (std::size_t c = 0; c < 3; ++c) {
        const float* const from = &s.moves[c][run.first];
        float* const to = &s.direction[c][run.first];
        for (int x = 0; x < run.count; ++x) to[x] = from[x] + keep * to[x];
      }
      sums[0] += dot(s.direction, s.forces, run);
    })[0];
  }

  void measure(double slope, double moves_squared, bool first) {
    Solver& s = *solver;
    const trace::Span span("spring energy");
    const auto sums = over_rows<3>(0, [&](const SpringRun& run, auto& total) {
      const SpringSums of_run = spring_sums(s.box, run, s.direction);
      total[0] += of_run.energy;
      total[1] += of_run.curvature;
      total[2] += of_run.bound;
    });
    check_finite(sums[0] + sums[1]);
    const double energy = sums[0] + s.guard.energy();
    // Settling takes back most of what a step costs the corners: counted in full, a few of them
    // would shorten every step (measured with all of it, a third, a tenth and a thirtieth).
    const double folds = kCornersLeft * s.guard.curvature(s.direction);
    const double curvature = sums[1] + folds;
    const double bound = sums[2] + std::max(0.0, folds);
    if (!first && energy > progress.energy_last * (1.0 + kEnergyNoise)) {
      s.caution = std::max(0.5 * s.caution, 1.0 / 64.0);
    } else {
      s.caution = std::min(1.0, 2.0 * s.caution);
      unpublished = true;
    }
    progress.energy_last = first ? energy : std::min(energy, progress.energy_last);
    const double full = curvature > 1e-3 * bound ? slope / curvature
                        : bound > 0.0            ? slope / bound
                                                 : 0.0;
    s.step = s.caution * full;
    estimate(full, moves_squared);
    progress.folded_corners = s.guard.folded();
  }

  void estimate(double step, double moves_squared) {
    Solver& s = *solver;
    const glm::dvec3 voxels_from_mm = 1.0 / s.box.spacing_mm();
    const Size3 extent = s.box.extent();
    struct Largest {
      double move = 0.0;
      double direction = 0.0;
    };
    std::vector<Largest> parts(static_cast<std::size_t>(extent.z));
    pool.for_each(extent.z, [&](std::int64_t plane, int) {
      const std::int64_t begin = plane * extent.x * extent.y;
      const std::int64_t count = std::int64_t{extent.x} * extent.y;
      const glm::vec3 scale(voxels_from_mm);
      const auto largest = [&](const BoxVectors& v) {
        const float* const x = &v[0][begin];
        const float* const y = &v[1][begin];
        const float* const z = &v[2][begin];
        float most = 0.0f;
        for (std::int64_t i = 0; i < count; ++i) {
          const float a = scale.x * x[i];
          const float b = scale.y * y[i];
          const float c = scale.z * z[i];
          const float size2 = a * a + b * b + c * c;
          most = size2 > most ? size2 : most;
        }
        return std::sqrt(double{most});
      };
      parts[static_cast<std::size_t>(plane)] = {largest(s.moves), largest(s.direction)};
    });
    Largest all;
    for (const Largest& part : parts) {
      all.move = std::max(all.move, part.move);
      all.direction = std::max(all.direction, part.direction);
    }
    s.furthest_voxels = all.direction;
    progress.residual_voxels = step * all.move;
    const double mm = std::sqrt(moves_squared / static_cast<double>(s.box.free_elements()));
    progress.residual_rms_voxels =
        step * mm * std::cbrt(voxels_from_mm.x * voxels_from_mm.y * voxels_from_mm.z);
  }

  void iterate() {
    if (progress.finished()) return;
    const trace::Span span("relaxation cycle");
    Solver& s = *solver;
    s.guard.advance(s.direction, s.step, s.step * s.furthest_voxels);
    aim(false);
    ++progress.iterations;
    progress.element_updates += s.box.free_elements();
    if (progress.residual_voxels < 0.9 * best_residual ||
        progress.energy_last < best_energy * (1.0 - kEnergyGain)) {
      best_residual = std::min(best_residual, progress.residual_voxels);
      best_energy = progress.energy_last;
      iterations_without_gain = 0;
    } else {
      ++iterations_without_gain;
    }
    if (progress.residual_voxels <= options.tolerance_voxels) {
      if (rim_is_pulled() && enlarge()) return;
      progress.converged = true;
    } else if (iterations_without_gain >= kPatience) {
      progress.at_float_limit = true;
    }
  }

  // Whether what lies beyond the region would be moved by more than the tolerance if it could: a
  // force at the rim moves it about as far as it would an element by itself, times the elements
  // between here and where something holds.
  bool rim_is_pulled() const {
    if (region.whole()) return false;
    return true;
  }

  bool enlarge() {
    static_cast<void>(lattice());
    if (!region.grow()) {
      progress.region_limited = region.limited();
      return false;
    }
    begin();
    best_residual = std::numeric_limits<double>::infinity();
    iterations_without_gain = 0;
    return true;
  }

  void check_finite(double sum) const {
    if (std::isfinite(sum)) return;
    const SpringBox& box = solver->box;
    const VoxelBox& free = box.free_box();
    for (int z = free.lo.z - 1; z <= free.hi.z; ++z) {
      for (int y = free.lo.y - 1; y <= free.hi.y; ++y) {
        for (int x = free.lo.x - 1; x <= free.hi.x; ++x) {
          const std::int64_t e = box.element(VoxelIndex{x, y, z});
          for (const auto& u : box.u_mm()) {
            if (std::isfinite(u[e])) continue;
            throw Failure({ErrorKind::failed, "relaxation: the displacement of element (" +
                                                  std::to_string(x) + ", " + std::to_string(y) +
                                                  ", " + std::to_string(z) +
                                                  ") is not a finite number"});
          }
        }
      }
    }
    throw Failure({ErrorKind::failed, "relaxation: the energy is not a finite number"});
  }

  Lattice lattice() {
    const trace::Span span("relaxation publish");
    if (unpublished && solver) published = solver->box.lattice(published, pool);
    unpublished = false;
    return published;
  }
};

Relaxation::Relaxation(const Lattice& start, const MaterialField& materials, const Cuts& cuts,
                       const ElementSet& held, AnchorRules anchors, WorkerPool& pool,
                       const RelaxationOptions& options, const std::optional<VoxelBox>& disturbed)
    : state_(std::make_unique<State>(start, materials, cuts, held, anchors, pool, options,
                                     disturbed)) {}
Relaxation::~Relaxation() = default;
Relaxation::Relaxation(Relaxation&&) noexcept = default;

const RelaxationProgress& Relaxation::iterate() {
  state_->iterate();
  return state_->progress;
}

const RelaxationProgress& Relaxation::progress() const { return state_->progress; }

Lattice Relaxation::lattice() { return state_->lattice(); }

std::vector<glm::dvec3> Relaxation::displacements_voxels() const {
  const Size3 size = state_->materials.size();
  std::vector<glm::dvec3> u(static_cast<std::size_t>(voxel_count(size)));
  std::size_t i = 0;
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) {
        u[i++] = state_->published.displacement_voxels({x, y, z});
      }
    }
  }
  if (!state_->solver) return u;
  const SpringBox& box = state_->solver->box;
  const VoxelBox& free = box.free_box();
  for (int z = free.lo.z; z < free.hi.z; ++z) {
    for (int y = free.lo.y; y < free.hi.y; ++y) {
      for (int x = free.lo.x; x < free.hi.x; ++x) {
        const std::int64_t e = box.element(VoxelIndex{x, y, z});
        if (box.is_free(e)) {
          u[static_cast<std::size_t>(linear_index({x, y, z}, size))] = box.displacement_voxels(e);
        }
      }
    }
  }
  return u;
}

std::int64_t Relaxation::bytes() const { return state_->solver ? state_->solver->bytes() : 0; }

}  // namespace maille
