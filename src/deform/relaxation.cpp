#include "deform/relaxation.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include "core/trace.h"
#include "deform/spring_lattice.h"

namespace maille {
namespace {

// The active list and the energy are looked after once in so many sweeps.
constexpr int kSweepsPerCheck = 16;
// A brick rests while nothing in it moves by more than this share of the tolerance.
constexpr double kRestingShare = 1e-3;
// Below this a move is rounding of the float state.
constexpr double kSmallestMove_voxels = 1e-6;
// Energies are sums of floats: a rise beyond this share is a rise.
constexpr double kEnergyNoise = 1e-6;

}  // namespace

struct Relaxation::State {
  RelaxationOptions options;
  WorkerPool& pool;
  SpringLattice springs;
  RelaxationProgress progress;
  std::vector<std::int64_t> active;
  Lattice published;
  double resting_move_voxels;
  std::deque<double> recent_moves;  // largest move of each of the last sweeps

  State(const Lattice& start, const MaterialField& materials, const Cuts& cuts,
        const ElementSet& held, AnchorRules anchors, WorkerPool& workers,
        const RelaxationOptions& wanted)
      : options(wanted),
        pool(workers),
        springs({start, materials, cuts, held, anchors, wanted.step, wanted.rest_vector_blend},
                workers.thread_count()),
        published(start),
        resting_move_voxels(wanted.tolerance_voxels * kRestingShare) {
    start.for_each_brick(
        [&](std::int64_t b, const LatticeBrick&) { springs.take_in_with_neighbours(b); });
    refresh_active();
    progress.energy_first = progress.energy_last = energy();
    progress.residual_voxels = active.empty() ? 0.0 : std::numeric_limits<double>::infinity();
    progress.converged = active.empty();
  }

  const std::vector<std::int64_t>& moving() const { return springs.bricks(); }

  double energy() {
    const trace::Span span("relaxation energy");
    std::vector<double> energies(moving().size());
    pool.for_each(static_cast<std::int64_t>(moving().size()), [&](std::int64_t i, int worker) {
      energies[static_cast<std::size_t>(i)] =
          springs.energy_of(moving()[static_cast<std::size_t>(i)], worker);
    });
    double sum = 0.0;  // in the order of the bricks: the same for any number of threads
    for (const double e : energies) sum += e;
    return sum;
  }

  void refresh_active() {
    active.clear();
    for (const std::int64_t b : moving()) {
      if (springs.brick(b).active && springs.brick(b).free_elements > 0) active.push_back(b);
    }
  }

  // Lets bricks rest that hardly moved in the last sweep and wakes those beside a face that did.
  void update_active() {
    const auto resting = static_cast<float>(resting_move_voxels);
    std::vector<std::int64_t> wake;
    for (const std::int64_t b : active) {
      SpringBrick& m = springs.brick(b);
      m.active = m.largest_move > resting;
      const BrickIndex brick = springs.grid().brick(b);
      for (int face = 0; face < 6; ++face) {
        if (m.face_move[static_cast<std::size_t>(face)] <= resting) continue;
        BrickIndex there = brick;
        there[face / 2] += face % 2 ? 1 : -1;
        if (springs.grid().contains(there)) wake.push_back(springs.grid().linear(there));
      }
    }
    for (const std::int64_t b : wake) {
      springs.take_in(b);
      springs.brick(b).active = springs.brick(b).free_elements > 0;
    }
    refresh_active();
  }

  void iterate() {
    if (progress.finished()) return;
    const trace::Span span("relaxation sweep");
    pool.for_each(static_cast<std::int64_t>(active.size()), [&](std::int64_t i, int worker) {
      springs.sweep(active[static_cast<std::size_t>(i)], worker);
    });
    float largest = 0.0f;
    for (const std::int64_t b : active) {
      SpringBrick& m = springs.brick(b);
      m.take_step();
      m.changed = true;
      largest = std::max(largest, m.largest_move);
      progress.element_updates += m.free_elements;
    }
    ++progress.iterations;
    progress.largest_move_voxels = largest;
    estimate_residual();
    if (progress.iterations % kSweepsPerCheck == 0) check();
  }

  // Distance left, taking the moves to go on shrinking at the rate of the last sweeps: the tail of
  // a geometric series, doubled, since the slowest modes shrink more slowly than that. The size of
  // one move alone can be a hundred times smaller than the error.
  void estimate_residual() {
    const bool at_floor = progress.largest_move_voxels <= kSmallestMove_voxels;
    const double move = std::max(progress.largest_move_voxels, kSmallestMove_voxels);
    // Moves at the floor are rounding and shrink no more: the rate is that of those before.
    if (!at_floor) recent_moves.push_back(move);
    if (recent_moves.size() > kSweepsPerCheck + 1) recent_moves.pop_front();
    if (!at_floor && recent_moves.size() <= kSweepsPerCheck) return;
    const double steps = static_cast<double>(recent_moves.size()) - 1.0;
    const double rate =
        steps > 0.0 ? std::pow(recent_moves.back() / recent_moves.front(), 1.0 / steps) : 0.5;
    progress.residual_voxels =
        rate < 1.0 ? 2.0 * move * rate / (1.0 - rate) : std::numeric_limits<double>::infinity();
  }

  void settle_energy() {
    const double now = energy();
    if (now > progress.energy_last * (1.0 + kEnergyNoise)) progress.energy_ever_rose = true;
    progress.energy_last = now;
  }

  void check() {
    settle_energy();
    progress.converged = progress.residual_voxels <= options.tolerance_voxels;
    progress.at_float_limit =
        !progress.converged && progress.largest_move_voxels <= kSmallestMove_voxels;
    if (progress.finished()) return;
    const std::size_t bricks_before = moving().size();
    update_active();
    if (active.empty()) {
      // All rest by the threshold, yet the estimate says there is some way to go: look closer.
      resting_move_voxels = std::max(resting_move_voxels * 0.1, kSmallestMove_voxels);
      for (const std::int64_t b : moving()) springs.brick(b).active = true;
      refresh_active();
    }
    // Springs newly counted in full would look like a rise.
    if (moving().size() != bricks_before) progress.energy_last = energy();
  }

  Lattice lattice() {
    const trace::Span span("relaxation publish");
    std::vector<std::int64_t> changed;
    for (const std::int64_t b : moving()) {
      if (springs.brick(b).changed) changed.push_back(b);
    }
    std::vector<Lattice::Change> changes(changed.size());
    pool.for_each(static_cast<std::int64_t>(changed.size()), [&](std::int64_t i, int) {
      const std::int64_t b = changed[static_cast<std::size_t>(i)];
      changes[static_cast<std::size_t>(i)] = {b, springs.rounded(b)};
    });
    for (const std::int64_t b : changed) springs.brick(b).changed = false;
    published.set(changes);
    return published;
  }
};

Relaxation::Relaxation(const Lattice& start, const MaterialField& materials, const Cuts& cuts,
                       const ElementSet& held, AnchorRules anchors, WorkerPool& pool,
                       const RelaxationOptions& options)
    : state_(std::make_unique<State>(start, materials, cuts, held, anchors, pool, options)) {}
Relaxation::~Relaxation() = default;
Relaxation::Relaxation(Relaxation&&) noexcept = default;

const RelaxationProgress& Relaxation::iterate() {
  state_->iterate();
  return state_->progress;
}

const RelaxationProgress& Relaxation::progress() const { return state_->progress; }

const RelaxationProgress& Relaxation::measure() {
  state_->settle_energy();
  return state_->progress;
}

Lattice Relaxation::lattice() { return state_->lattice(); }

std::int64_t Relaxation::bytes() const { return state_->springs.bytes(); }

}  // namespace maille
