#include "deform/equilibrium_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/failure.h"
#include "core/trace.h"
#include "deform/half_resolution.h"
#include "deform/open_rounding.h"
#include "deform/settle_rounding.h"
#include "deform/spring_rows.h"

namespace maille {
namespace {

// Energies are sums of floats: a rise beyond this share is a rise.
constexpr double kEnergyNoise = 1e-7;
constexpr double kLeastOfCorners = 0.1;
// What multigrid takes for strain, though it is a turn, needs many times the move that it gives (60
// of them around a stiff ball in voxels of 1:10:10); a lattice about to buckle bends as little. So
// steps may be twice as long each time that the energy has fallen.
constexpr double kLongestStep = 20.0;
constexpr double kLongestOfAll = 1000.0;
// Elements near folding are settled to this share of what is left for all.
constexpr double kSettled = 0.2;

double dot(const BoxVectors& a, const BoxVectors& b, const SpringRun& run) {
  double sum = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    sum += dot_of_run(&a[c][run.first], &b[c][run.first], run.count);
  }
  return sum;
}

}  // namespace

// Sums over the rows of the free elements, in the order of the rows.
template <std::size_t kSums, class F>
std::array<double, kSums> EquilibriumSearch::over_rows(int margin, F&& f) {
  const Size3 extent = box_->extent();
  std::vector<std::array<double, kSums>> parts(static_cast<std::size_t>(extent.z));
  pool_.for_each(extent.z - 2 * margin, [&](std::int64_t plane, int) {
    auto& sums = parts[static_cast<std::size_t>(plane)];
    sums.fill(0.0);
    for (int y = margin; y < extent.y - margin; ++y) {
      const std::int64_t row = box_->row(y, static_cast<int>(plane) + margin);
      if (margin > 0 && box_->kind(row) == RowKind::held) continue;
      const auto add = [&](const SpringRun& run) { f(run, sums); };
      // The first element apart: the springs of a row's others all have a free end, or none is sure
      // to. The last one's even springs have none.
      if (margin == 0) for_each_run(*box_, row, 0, 1, add);
      for_each_run(*box_, row, 1, extent.x - 1, add);
    }
  });
  std::array<double, kSums> total{};
  for (const auto& part : parts) {
    for (std::size_t i = 0; i < kSums; ++i) total[i] += part[i];
  }
  return total;
}

EquilibriumSearch::EquilibriumSearch(std::unique_ptr<SpringBox> box, WorkerPool& pool)
    : pool_(pool),
      box_(std::move(box)),
      multigrid_(*box_, pool),
      guard_(*box_, pool),
      forces_(make_box_vectors(box_->extent(), pool)),
      moves_(make_box_vectors(box_->extent(), pool)),
      direction_(box_->extent(), pool),
      turns_(*box_, multigrid_, forces_, moves_),
      longest_step_(kLongestStep),
      share_of_corners_(kLeastOfCorners) {
  energy_at_start_ = spring_energy() + guard_.energy();
  check_finite(energy_at_start_);
  // Below this a cycle takes less than making another box does.
  constexpr std::int64_t kLarge = 10'000;
  // Nor does a coarse box tell well what two sides of a cut have to do with each other.
  if (box_->free_elements() > kLarge && !box_->lacks_springs()) start_from_half_resolution();
  aim(true);
}

double EquilibriumSearch::spring_energy() {
  return over_rows<1>(0, [&](const SpringRun& run, auto& sums) {
    sums[0] += spring_sums(*box_, run, direction_).energy;
  })[0];
}

EquilibriumSearch::Rounded EquilibriumSearch::rounded(const Lattice& published, bool settled) {
  OpenRounding rounding = open_rounding(*box_, pool_);
  // Forces are made anew by each cycle: meanwhile their memory is free.
  box_->round_to_fixed_point(forces_, pool_);
  for (const auto& [e, u_mm] : rounding.elsewhere) {
    for (int c = 0; c < 3; ++c) {
      forces_[static_cast<std::size_t>(c)][e] = static_cast<float>(u_mm[c]);
    }
  }
  if (settled) {
    std::vector<CellCorner> kept = rounding.at_risk;
    kept.insert(kept.end(), guard_.bent().begin(), guard_.bent().end());
    settle_rounding(*box_, kept, forces_, pool_);
  }
  std::swap(box_->u_mm(), forces_);
  Rounded rounded{box_->lattice(published, pool_), spring_energy() + guard_.energy(),
                  std::move(rounding.at_risk)};
  std::swap(box_->u_mm(), forces_);
  return rounded;
}

void EquilibriumSearch::start_from_half_resolution() {
  const trace::Span span("relaxation at half resolution");
  auto half = SpringBox::at_half_resolution(*box_, pool_);
  if (half->free_elements() == 0) return;
  BoxVectors before = make_box_vectors(half->extent(), pool_);
  for (std::size_t c = 0; c < 3; ++c) before[c].take_values_of(half->u_mm()[c]);
  EquilibriumSearch search(std::move(half), pool_);
  // Finer differences than this are those between the two resolutions.
  constexpr int kMostCycles = 12;
  constexpr double kEnough_voxels = 0.02;
  for (int i = 0; i < kMostCycles && search.rms_voxels() > kEnough_voxels; ++i) search.cycle();
  const double enough_voxels = kSettled * search.rms_voxels();
  // Where coarse elements are is a better guess than what they moved by, added to the creases that
  // ChainMail leaves. But beyond a free face there are none to tell, and around cells that are
  // folded anyway a leap ties knots.
  if (search.leapt_ && guard_.folded() == 0 && !box_->may_lack_springs()) {
    const double furthest = interpolate_moves(search.box(), nullptr, *box_, moves_, pool_);
    if (guard_.leap(moves_, furthest, enough_voxels, forces_)) return;
  }
  leapt_ = false;
  const double furthest = interpolate_moves(search.box(), &before, *box_, moves_, pool_);
  // As far at a time as folds few cells, so that those between can follow.
  constexpr int kMostParts = 8;
  double left = 1.0;
  for (int part = 0; part < kMostParts && left > 1e-3; ++part) {
    left -= guard_.advance(moves_, left, furthest, enough_voxels);
  }
}

void EquilibriumSearch::cycle() {
  const trace::Span span("relaxation cycle");
  static_cast<void>(guard_.advance(direction_, step_, furthest_voxels_, kSettled * rms_voxels_));
  aim(false);
}

// Forces of the state as it is; moves become stale.
void EquilibriumSearch::compute_forces() {
  const trace::Span span("spring forces");
  static_cast<void>(over_rows<1>(1, [&](const SpringRun& run, auto&) {
    RunVectors force;
    spring_forces(*box_, run, force);
    const std::uint8_t* const free = box_->free_flags() + run.first;
    const float* const parts[3] = {force.x, force.y, force.z};
    for (std::size_t c = 0; c < 3; ++c) {
      float* const to = &forces_[c][run.first];
      for (int x = 0; x < run.count; ++x) to[x] = free[x] ? parts[c][x] : 0.0f;
    }
  }));
  guard_.add_forces(forces_);
}

// Multigrid knows springs alone: it would send an element far through the wall that pushes it. So
// forces on the few in a wall count, and their moves are, by the share that springs have of their
// stiffness, the root of it each time, so that the inverse stays symmetric.
void EquilibriumSearch::solve_for_moves(bool with_turns) {
  const auto shares = guard_.spring_shares();
  std::vector<std::array<float, 3>> all;
  all.reserve(shares.size());
  for (const auto& [e, root] : shares) {
    all.push_back({forces_[0][e], forces_[1][e], forces_[2][e]});
    for (auto& component : forces_) component[e] *= root;
  }
  if (with_turns) turns_.take(forces_);
  multigrid_.solve(forces_, moves_);
  if (with_turns) {
    turns_.give_back(forces_);
    turns_.add(moves_);
  }
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const auto& [e, root] = shares[i];
    for (std::size_t c = 0; c < 3; ++c) {
      forces_[c][e] = all[i][c];
      moves_[c][e] *= root;
    }
  }
}

// The direction and length of the next step, and what can be told from them.
void EquilibriumSearch::aim(bool first) {
  compute_forces();
  double old_moves_dot_forces = 0.0;
  if (!first) {
    old_moves_dot_forces = over_rows<1>(
        1, [&](const SpringRun& run, auto& sums) { sums[0] += dot(moves_, forces_, run); })[0];
  }
  const auto solve = [&](bool with_turns) {
    solve_for_moves(with_turns);
    return over_rows<2>(1, [&](const SpringRun& run, auto& sums) {
      sums[0] += dot(moves_, forces_, run);
      sums[1] += dot(moves_, moves_, run);
    });
  };
  auto now = solve(!turns_.empty());
  // First turns, then multigrid: an inverse that is not symmetric may point uphill.
  if (!(now[0] > 0.0) && !turns_.empty()) now = solve(false);
  check_finite(now[0] + now[1]);
  const double keep = first || !(moves_dot_forces_ > 0.0)
                          ? 0.0
                          : std::max(0.0, (now[0] - old_moves_dot_forces) / moves_dot_forces_);
  moves_dot_forces_ = now[0];
  double slope = turn(static_cast<float>(keep));
  if (!(slope > 0.0) && keep > 0.0) slope = turn(0.0f);
  measure(slope, now[1], first);
}

// direction = moves + keep * direction; returns its dot product with the forces.
double EquilibriumSearch::turn(float keep) {
  const trace::Span span("direction");
  const glm::vec3 voxels_from_mm(1.0 / box_->spacing_mm());
  const Size3 extent = box_->extent();
  struct Part {
    double slope = 0.0;
    float furthest_squared = 0.0f;
  };
  std::vector<Part> parts(static_cast<std::size_t>(extent.z));
  pool_.for_each(extent.z, [&](std::int64_t plane, int) {
    const auto columns = static_cast<std::size_t>(extent.x);
    std::vector<float> buffer(3 * columns);
    const std::array<float*, 3> d = {buffer.data(), &buffer[columns], &buffer[2 * columns]};
    Part& part = parts[static_cast<std::size_t>(plane)];
    for (std::int64_t row = plane * extent.y; row < (plane + 1) * extent.y; ++row) {
      if (box_->kind(row) == RowKind::held) continue;
      const std::int64_t begin = row * extent.x;
      direction_.get_row(row, d[0], d[1], d[2]);
      for (std::size_t c = 0; c < 3; ++c) {
        const float* const move = &moves_[c][begin];
        float* const to = d[c];
        for (int x = 0; x < extent.x; ++x) to[x] = move[x] + keep * to[x];
      }
      direction_.set_row(row, d[0], d[1], d[2]);
      direction_.get_row(row, d[0], d[1], d[2]);
      for (std::size_t c = 0; c < 3; ++c) {
        part.slope += dot_of_run(d[c], &forces_[c][begin], extent.x);
      }
      part.furthest_squared = std::max(part.furthest_squared,
                                       largest_square(d[0], d[1], d[2], voxels_from_mm, extent.x));
    }
  });
  double slope = 0.0;
  float furthest_squared = 0.0f;
  for (const Part& part : parts) {
    slope += part.slope;
    furthest_squared = std::max(furthest_squared, part.furthest_squared);
  }
  furthest_voxels_ = std::sqrt(double{furthest_squared});
  return slope;
}

void EquilibriumSearch::measure(double slope, double moves_squared, bool first) {
  const trace::Span span("spring energy");
  const auto sums = over_rows<2>(0, [&](const SpringRun& run, auto& total) {
    const SpringSums of_run = spring_sums(*box_, run, direction_);
    total[0] += of_run.energy;
    total[1] += of_run.curvature;
  });
  check_finite(sums[0] + sums[1]);
  const double energy = sums[0] + guard_.energy();
  const bool rose = !first && energy > energy_ * (1.0 + kEnergyNoise) &&
                    energy > last_energy_ * (1.0 - kEnergyNoise);
  last_energy_ = energy;
  if (rose) {
    caution_ = std::max(0.5 * caution_, 1.0 / 64.0);
    longest_step_ = kLongestStep;
    share_of_corners_ = std::min(1.0, 3.0 * share_of_corners_);
  } else {
    caution_ = std::min(1.0, 2.0 * caution_);
    longest_step_ = std::min(2.0 * longest_step_, kLongestOfAll);
    share_of_corners_ = std::max(kLeastOfCorners, 0.8 * share_of_corners_);
  }
  // Settling takes back most of what a step costs the corners: counted in full, a few of them
  // would shorten every step (measured with all of it, a third, a tenth and a thirtieth).
  const double folds = share_of_corners_ * guard_.curvature(direction_);
  const double curvature = sums[1] + folds;
  energy_ = first ? energy : std::min(energy, energy_);
  const double full = length_of_step(slope, curvature, folds);
  step_ = caution_ * full;
  estimate(full, moves_squared);
}

// To the least energy along the direction, if that is not too far; no further than is safe from any
// state where the energy bends down, as a lattice about to buckle does.
double EquilibriumSearch::length_of_step(double slope, double curvature, double folds) {
  if (!(slope > 0.0)) return 0.0;
  if (curvature > slope / longest_step_) return slope / curvature;
  if (curvature > 0.0 && longest_step_ > kLongestStep) return longest_step_;
  const double bound =
      over_rows<1>(0, [&](const SpringRun& run,
                          auto& sums) { sums[0] += spring_bound(*box_, run, direction_); })[0] +
      std::max(0.0, folds);
  return bound > 0.0 ? slope / bound : 0.0;
}

void EquilibriumSearch::estimate(double step, double moves_squared) {
  // No curvature of springs shortens a step further (length_of_step). Corners can, or there is no
  // way down at all: that tells how steep the way is, not how short.
  constexpr double kShortestStep = 1.0 / 5.0;
  step = std::max(step, kShortestStep);
  const glm::dvec3 voxels_from_mm = 1.0 / box_->spacing_mm();
  const Size3 extent = box_->extent();
  std::vector<double> largest(static_cast<std::size_t>(extent.z));
  pool_.for_each(extent.z, [&](std::int64_t plane, int) {
    const std::int64_t begin = plane * extent.x * extent.y;
    largest[static_cast<std::size_t>(plane)] =
        double{largest_square(&moves_[0][begin], &moves_[1][begin], &moves_[2][begin],
                              glm::vec3(voxels_from_mm), extent.x * extent.y)};
  });
  largest_voxels_ = step * std::sqrt(*std::max_element(largest.begin(), largest.end()));
  const double mm = std::sqrt(moves_squared / static_cast<double>(box_->free_elements()));
  rms_voxels_ = step * mm * std::cbrt(voxels_from_mm.x * voxels_from_mm.y * voxels_from_mm.z);
}

void EquilibriumSearch::check_finite(double sum) const {
  if (std::isfinite(sum)) return;
  const SpringBox& box = *box_;
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

std::int64_t EquilibriumSearch::bytes() const {
  return box_->bytes() + multigrid_.bytes() + turns_.bytes() + bytes_of(forces_) +
         bytes_of(moves_) + direction_.bytes();
}

}  // namespace maille
