#include "deform/relaxation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <string>

#include "core/trace.h"
#include "deform/disturbance.h"
#include "deform/equilibrium_search.h"
#include "deform/relaxation_region.h"
#include "deform/rim_pull.h"
#include "deform/spring_box.h"
#include "deform/state_trail.h"
#include "deform/yield_flow.h"

namespace maille {
namespace {

// What a free element takes: four vectors, flags and the coarser levels; stiffness, blend and what
// smoothing needs of them where there are several materials; one more vector where material has
// yielded.
constexpr std::int64_t kBytesPerElement = 64;
constexpr std::int64_t kBytesOfMaterials = 10;
constexpr std::int64_t kBytesPerYielded = 12;
// Where in so many iterations neither estimate has fallen by a tenth, nor the energy by this share,
// nor has a corner unfolded, they will not. Far from equilibrium estimates rise and fall while the
// energy only falls. Nor goes a search on for ever whose energy crawls.
// One small estimate may be luck; and how fast moves shrink tells more the longer it is watched.
constexpr int kConfirmed = 2;
constexpr int kRest = 8;  // around folded cells
// The estimate may be so many times too small.
constexpr double kEstimateIsTrueTo = 3.0;
constexpr int kPatience = 20;
constexpr double kEnergyGain = 3e-3;
constexpr int kMostIterations = 600;

std::int64_t most_elements(std::int64_t bytes, bool several_materials, bool yielded) {
  return std::max<std::int64_t>(
      1, bytes / (kBytesPerElement + (several_materials ? kBytesOfMaterials : 0) +
                  (yielded ? kBytesPerYielded : 0)));
}

}  // namespace

struct Relaxation::State {
  const MaterialField& materials;
  Cuts cuts;
  ElementSet held;
  AnchorRules anchors;
  WorkerPool& pool;
  RelaxationOptions options;
  RelaxationProgress progress;
  Lattice kept;
  std::optional<ElementSet> held_after_flow;  // until then `held` has what was released too
  bool flown = false;
  VoxelBox disturbed;
  RelaxationRegion region;
  Lattice published;

  std::unique_ptr<EquilibriumSearch> search;  // of the region; none where nothing is free
  std::vector<glm::dvec3> rim_before;
  std::optional<StateTrail> trail;
  double rim_pull = 0.0;  // voxels, when last looked at
  std::deque<double> rms_lately;
  double best_residual = std::numeric_limits<double>::infinity();
  double best_rms = std::numeric_limits<double>::infinity();
  double best_left = std::numeric_limits<double>::infinity();
  double best_energy = std::numeric_limits<double>::infinity();
  std::int64_t least_folded = std::numeric_limits<std::int64_t>::max();
  int iterations_without_gain = 0;
  int iterations_within = 0;  // the tolerance, up to now
  int iterations_here = 0;    // since the region last grew
  bool unpublished = false;   // the search has moved on since
  double published_energy = 0.0;
  bool energy_known = false;  // of what is published, in the region that there is now

  State(const Lattice& start, const MaterialField& field, const Cuts& gone, const ElementSet& holds,
        AnchorRules rules, WorkerPool& workers, const RelaxationOptions& wanted,
        const std::optional<VoxelBox>& changed, const Yielding& yielding)
      : materials(field),
        cuts(gone),
        held(holds),
        anchors(rules),
        pool(workers),
        options(wanted),
        kept(yielding.kept.at_rest() ? Lattice(field.size()) : yielding.kept),
        disturbed(changed.value_or(united(moved_box(start), moved_box(kept)))),
        region(region_around(disturbed)),
        published(start) {
    if (!yielding.released.empty() && field.table().any_yields()) {
      held_after_flow = held;
      held.insert(yielding.released);
    }
    start_search();
  }

  RelaxationRegion region_around(const VoxelBox& box) const {
    return {box, materials.size(), anchors,
            most_elements(options.memory_bytes, !materials.single_material(), !kept.at_rest())};
  }

  void start_search() {
    search.reset();
    if (!region.box().empty()) begin();
    if (!search && held_after_flow) flow();
    if (!search) settle_without_work();
  }

  // From the equilibrium with what was released still held; then that is free.
  void flow() {
    const Lattice start = lattice();
    search.reset();  // and its memory
    YieldFlow done = let_yield({start, kept, materials, cuts, options.memory_bytes}, pool);
    kept = std::move(done.kept);
    flown = true;
    energy_known = false;  // springs rest elsewhere
    held = *std::exchange(held_after_flow, std::nullopt);
    progress.converged = progress.no_nearer = false;
    region = region_around(united(disturbed, done.yielded));
    start_search();
    progress.region_limited = progress.region_limited || done.limited;
  }

  void settle_without_work() {
    progress.converged = true;
    progress.residual_voxels = progress.residual_rms_voxels = 0.0;
  }

  // A search in the region as it is now, from what is published.
  void begin() {
    const trace::Span span("relaxation set-up");
    search.reset();
    auto box = std::make_unique<SpringBox>(
        SpringBox::Problem{published, materials, cuts, held, anchors, &kept}, region.box(), pool);
    if (box->free_elements() == 0) return;
    rim_before = rim_forces(*box, region.whole_box());
    search = std::make_unique<EquilibriumSearch>(std::move(box), pool);
    trail.emplace(search->box());
    progress.free_elements = search->box().free_elements();
    progress.region_limited = region.limited();
    // What a larger region takes in beside the last one is at rest: the energy stays what it was,
    // to what sums of floats leave out.
    constexpr double kEnergySums = 1e-5;
    const double energy = search->energy_at_start();
    if (!energy_known) progress.energy_first = energy;
    if (energy_known && energy > published_energy * (1.0 + kEnergySums)) {
      progress.energy_ever_rose = true;
    }
    energy_known = true;
    progress.energy_last = published_energy = energy;
    rms_lately.clear();
    best_residual = best_rms = best_left = best_energy = std::numeric_limits<double>::infinity();
    least_folded = std::numeric_limits<std::int64_t>::max();
    iterations_without_gain = iterations_here = iterations_within = 0;
    note();
  }

  // How much further it is than one move goes. Steps to come go on shrinking as they have of late:
  // where multigrid sees part of the error badly (turns of stiff parts, the sides of cuts), slowly.
  // Those of conjugate gradients are orthogonal in energy, so their squares add up (Hestenes and
  // Stiefel 1952, Strakos and Tichy 2002).
  double steps_to_come(double rms_voxels) {
    constexpr std::size_t kLately = 3;
    constexpr double kSlowest = 0.95;
    constexpr double kMargin = 1.25;  // moves are rather too short than too long
    const bool known = rms_lately.size() >= kLately && rms_lately.front() > 0.0;
    const double rate =
        known ? std::pow(rms_voxels / rms_lately.front(), 1.0 / static_cast<double>(kLately)) : 0.3;
    rms_lately.push_back(rms_voxels);
    if (rms_lately.size() > kLately) rms_lately.pop_front();
    const double shrink = std::min(rate, kSlowest);
    return kMargin / std::sqrt(1.0 - shrink * shrink);
  }

  void note() {
    unpublished = true;
    progress.energy_last = std::min(search->energy(), progress.energy_last);
    trail->add(search->box());
    const StateTrail::Left left = trail->left();
    const double to_come = steps_to_come(search->rms_voxels());
    const double step_voxels = to_come * search->largest_voxels();
    const double step_rms_voxels = to_come * search->rms_voxels();
    progress.folded_corners = search->folded_corners();
    // Around folded cells, where the energy has a kink, moves go to and fro for ever: there it is
    // over when the state has come to rest.
    const bool to_and_fro = progress.folded_corners > 0 && iterations_here >= kRest;
    const double here_voxels =
        std::max({to_and_fro ? 0.0 : step_voxels, left.largest_voxels, search->rounding_voxels()});
    progress.residual_voxels = std::max(here_voxels, rim_voxels());
    progress.residual_rms_voxels = std::max(to_and_fro ? 0.0 : step_rms_voxels, left.rms_voxels);
    if (step_voxels < 0.9 * best_residual || step_rms_voxels < 0.9 * best_rms ||
        left.largest_voxels < 0.9 * best_left || (left.one_way && progress.folded_corners == 0) ||
        progress.folded_corners < least_folded ||
        progress.energy_last < best_energy * (1.0 - kEnergyGain)) {
      best_residual = std::min(best_residual, step_voxels);
      best_rms = std::min(best_rms, step_rms_voxels);
      best_left = std::min(best_left, left.largest_voxels);
      least_folded = std::min(least_folded, progress.folded_corners);
      best_energy = progress.energy_last;
      iterations_without_gain = 0;
    } else {
      ++iterations_without_gain;
    }
    const bool within = here_voxels <= options.tolerance_voxels / kEstimateIsTrueTo;
    iterations_within = within ? iterations_within + 1 : 0;
    if (iterations_within >= (to_and_fro ? kRest : kConfirmed)) {
      rim_pull = rim_pull_now();
      if (rim_pull > options.tolerance_voxels && enlarge()) return;
      rim_pull = rim_pull_now();
      progress.residual_voxels = std::max(here_voxels, rim_pull);
      progress.converged = true;
    } else if (!within &&
               (iterations_without_gain >= kPatience || iterations_here >= kMostIterations)) {
      // A knot may never come to rest; what lies further out has no part in that.
      rim_pull = rim_pull_now();
      if (rim_pull > options.tolerance_voxels && enlarge()) return;
      progress.no_nearer = true;
    }
    // What is said of the end holds for what is given out of it.
    if (progress.finished()) publish_state();
    if (progress.finished() && held_after_flow) flow();
  }

  void iterate() {
    if (progress.finished()) return;
    ++progress.iterations;
    ++iterations_here;
    progress.element_updates += progress.free_elements;
    search->cycle();
    note();
  }

  // Where memory allows no larger a region, its rim is held: that is what was asked for then.
  double rim_pull_now() const {
    if (region.whole() || region.limited()) return 0.0;
    return rim_pull_voxels(search->box(), region.whole_box(), rim_before);
  }

  // How far what lies beyond the region would go; looked at now and then, for it changes slowly.
  double rim_voxels() {
    constexpr int kEvery = 4;
    if (iterations_here % kEvery == 0) rim_pull = rim_pull_now();
    return rim_pull;
  }

  bool enlarge() {
    static_cast<void>(lattice());
    if (!region.grow()) {
      progress.region_limited = region.limited();
      return false;
    }
    begin();
    return true;
  }

  // Whether a cell that is open in the state given last is folded in the next one.
  bool folds_any(const std::vector<CellCorner>& corners, const Lattice& next) const {
    const SpringBox& box = search->box();
    const FoldEnergy folds(box);
    const auto is_folded = [&](const Lattice& lattice, const CellCorner& corner) {
      const VoxelIndex at = box.voxel(corner.element);
      glm::dmat3 edges(1.0);
      for (int axis = 0; axis < 3; ++axis) {
        const int sign = (corner.signs >> axis) & 1 ? -1 : 1;
        VoxelIndex beside = at;
        beside[axis] += sign;
        edges[axis] += static_cast<double>(sign) *
                       (lattice.displacement_voxels(beside) - lattice.displacement_voxels(at));
      }
      return glm::determinant(edges) <= 0.0;
    };
    return std::any_of(corners.begin(), corners.end(), [&](const CellCorner& corner) {
      if (!is_folded(next, corner)) return false;
      bool was_folded = false;
      folds.for_each_corner_of_cell(folds.cell_of(corner), [&](const CellCorner& of_cell) {
        was_folded = was_folded || is_folded(published, of_cell);
      });
      return !was_folded;
    });
  }

  bool publish(EquilibriumSearch::Rounded& next) {
    if (!(next.energy <= published_energy) || folds_any(next.at_risk, next.lattice)) return false;
    published = std::move(next.lattice);
    published_energy = next.energy;
    return true;
  }

  // What was given out last may have stayed behind the end of the search.
  void end_with(const Lattice& last) {
    const double behind_voxels = furthest_apart(published, last);
    if (behind_voxels <= options.tolerance_voxels / kEstimateIsTrueTo) return;
    EquilibriumSearch::Rounded settled = search->rounded(published, true);
    if (publish(settled)) return;
    progress.residual_voxels += behind_voxels;
    progress.residual_rms_voxels += behind_voxels;
    if (progress.residual_voxels > options.tolerance_voxels) {
      progress.converged = false;
      progress.no_nearer = true;
    }
  }

  double furthest_apart(const Lattice& a, const Lattice& b) const {
    const VoxelBox& free = search->box().free_box();
    std::vector<double> largest(static_cast<std::size_t>(free.size().z));
    pool.for_each(free.size().z, [&](std::int64_t plane, int) {
      double& most = largest[static_cast<std::size_t>(plane)];
      VoxelIndex at = free.lo;
      at.z += static_cast<int>(plane);
      for (at.y = free.lo.y; at.y < free.hi.y; ++at.y) {
        for (at.x = free.lo.x; at.x < free.hi.x; ++at.x) {
          const glm::dvec3 d = a.displacement_voxels(at) - b.displacement_voxels(at);
          most = std::max(most, glm::dot(d, d));
        }
      }
    });
    return std::sqrt(*std::max_element(largest.begin(), largest.end()));
  }

  // Rounding may undo, near the end, what little a cycle has won, and fold a cell that no other way
  // to round keeps open: then what was given last is given again.
  void publish_state() {
    const trace::Span span("relaxation publish");
    if (!unpublished || !search) return;
    unpublished = false;
    EquilibriumSearch::Rounded next = search->rounded(published, false);
    if (!publish(next) && progress.finished()) end_with(next.lattice);
  }

  Lattice lattice() {
    publish_state();
    if (search) progress.energy_last = published_energy;
    return published;
  }
};

Relaxation::Relaxation(const Lattice& start, const MaterialField& materials, const Cuts& cuts,
                       const ElementSet& held, AnchorRules anchors, WorkerPool& pool,
                       const RelaxationOptions& options, const std::optional<VoxelBox>& disturbed,
                       const Yielding& yielding)
    : state_(std::make_unique<State>(start, materials, cuts, held, anchors, pool, options,
                                     disturbed, yielding)) {}
Relaxation::~Relaxation() = default;
Relaxation::Relaxation(Relaxation&&) noexcept = default;

const RelaxationProgress& Relaxation::iterate() {
  state_->iterate();
  return state_->progress;
}

const RelaxationProgress& Relaxation::progress() const { return state_->progress; }

Lattice Relaxation::lattice() { return state_->lattice(); }

const Lattice* Relaxation::kept_by_flow() const { return state_->flown ? &state_->kept : nullptr; }

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
  if (!state_->search) return u;
  const SpringBox& box = state_->search->box();
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

std::int64_t Relaxation::bytes() const {
  return state_->search ? state_->search->bytes() + state_->trail->bytes() : 0;
}

}  // namespace maille
