#include "deform/relaxation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>

#include "core/trace.h"
#include "deform/spring_forces.h"

namespace maille {
namespace {

constexpr int kHaloPlane = kSpringHaloEdge * kSpringHaloEdge;
constexpr std::size_t kHaloElements = std::size_t{kHaloPlane} * kSpringHaloEdge;
constexpr float kNoSpring = std::numeric_limits<float>::infinity();  // as a compliance

// The active list and the energy are looked after once in so many sweeps.
constexpr int kSweepsPerCheck = 16;
// A brick rests while nothing in it moves by more than this share of the tolerance.
constexpr double kRestingShare = 1e-3;
// Below this a move is rounding of the float state.
constexpr double kSmallestMove_voxels = 1e-6;
// Energies are sums of floats: a rise beyond this share is a rise.
constexpr double kEnergyNoise = 1e-6;

// The materials of a brick as the sweep wants them.
struct BrickSprings {
  std::vector<float> compliance;  // 1 / stiffness; infinite beyond the volume: no spring there
};

// A brick that takes part.
struct BrickMotion {
  std::vector<float> u_mm[3];
  std::vector<float> next_mm[3];
  std::vector<float> gain;  // step / sum of stiffnesses; 0 holds the element
  std::int64_t free_elements = 0;
  bool active = true;
  bool changed = true;  // since lattice() last looked
  // Largest moves of the last sweep, in voxels: anywhere, and in each face's layer.
  float largest_move = 0.0f;
  std::array<float, 6> face_move{};
};

// A brick and one element around it, gathered so that the sweep runs straight through memory.
struct Halo {
  std::vector<float> u_mm[3];
  std::vector<float> compliance;
  Halo() : compliance(kHaloElements) {
    for (auto& u : u_mm) u.resize(kHaloElements);
  }
};

}  // namespace

struct Relaxation::State {
  Lattice start;
  const MaterialField& materials;
  ElementSet held;
  AnchorRules anchors;
  WorkerPool& pool;
  RelaxationOptions options;
  glm::dvec3 spacing_mm;
  Springs springs;
  RelaxationProgress progress;

  std::vector<std::unique_ptr<BrickSprings>> bricks_springs;
  std::vector<std::unique_ptr<BrickMotion>> motions;
  std::vector<std::int64_t> moving;  // bricks with a motion, by rising index
  std::vector<std::int64_t> active;
  std::vector<Halo> halos;  // one a worker
  Lattice published;
  double resting_move_voxels;
  std::deque<double> recent_moves;  // largest move of each of the last sweeps

  State(const Lattice& lattice, const MaterialField& field, const ElementSet& held_elements,
        AnchorRules anchor_rules, WorkerPool& workers, const RelaxationOptions& wanted)
      : start(lattice),
        materials(field),
        held(held_elements),
        anchors(anchor_rules),
        pool(workers),
        options(wanted),
        spacing_mm(field.spacing_mm()),
        springs(springs_of(field.spacing_mm())),
        bricks_springs(static_cast<std::size_t>(lattice.grid().count())),
        motions(static_cast<std::size_t>(lattice.grid().count())),
        halos(static_cast<std::size_t>(workers.thread_count())),
        published(lattice),
        resting_move_voxels(wanted.tolerance_voxels * kRestingShare) {
    start.for_each_brick([&](std::int64_t b, const LatticeBrick&) { take_in_with_neighbours(b); });
    refresh_active();
    progress.energy_first = progress.energy_last = energy();
    progress.residual_voxels = active.empty() ? 0.0 : std::numeric_limits<double>::infinity();
    progress.converged = active.empty();
  }

  const BrickGrid& grid() const { return start.grid(); }
  BrickMotion& motion(std::int64_t b) { return *motions[static_cast<std::size_t>(b)]; }
  const BrickMotion* motion_or_none(std::int64_t b) const {
    return motions[static_cast<std::size_t>(b)].get();
  }

  template <class F>
  void for_each_neighbour(BrickIndex brick, F&& f) const {
    for (int z = -1; z <= 1; ++z) {
      for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
          const BrickIndex there = brick + BrickIndex(x, y, z);
          if (grid().contains(there)) f(grid().linear(there));
        }
      }
    }
  }

  void take_in_with_neighbours(std::int64_t b) {
    for_each_neighbour(grid().brick(b), [&](std::int64_t n) { take_in(n); });
  }

  void take_in(std::int64_t b) {
    if (motions[static_cast<std::size_t>(b)]) return;
    for_each_neighbour(grid().brick(b), [&](std::int64_t n) { prepare_springs(n); });
    auto motion = std::make_unique<BrickMotion>();
    const LatticeBrick* from = start.brick(b);
    for (int c = 0; c < 3; ++c) {
      motion->u_mm[c].assign(kBrickVoxels, 0.0f);
      if (from) {
        const double mm_from_units = spacing_mm[c] / kUnitsPerVoxel;
        for (int row = 0; row < kBrickEdge * kBrickEdge; ++row) {
          std::int32_t u[kBrickEdge];
          from->read_row(c, row, u);
          for (int x = 0; x < kBrickEdge; ++x) {
            motion->u_mm[c][static_cast<std::size_t>(row * kBrickEdge + x)] =
                static_cast<float>(u[x] * mm_from_units);
          }
        }
      }
      motion->next_mm[c] = motion->u_mm[c];
    }
    motions[static_cast<std::size_t>(b)] = std::move(motion);
    prepare_gains(b);
    moving.insert(std::lower_bound(moving.begin(), moving.end(), b), b);
  }

  void prepare_springs(std::int64_t b) {
    auto& slot = bricks_springs[static_cast<std::size_t>(b)];
    if (slot) return;
    slot = std::make_unique<BrickSprings>();
    slot->compliance.assign(kBrickVoxels, kNoSpring);
    const VoxelBox box = grid().box(grid().brick(b));
    std::vector<MaterialId> ids(static_cast<std::size_t>(voxel_count(box.size())));
    materials.read(box, ids);
    auto id = ids.begin();
    for (int z = box.lo.z; z < box.hi.z; ++z) {
      for (int y = box.lo.y; y < box.hi.y; ++y) {
        for (int x = box.lo.x; x < box.hi.x; ++x) {
          slot->compliance[static_cast<std::size_t>(element_in_brick({x, y, z}))] =
              materials.table().compliance(*id++);
        }
      }
    }
  }

  bool is_held(VoxelIndex voxel, const ElementSet::Mask* mask, bool fixed_materials) const {
    if (mask && mask->test(static_cast<std::size_t>(element_in_brick(voxel)))) return true;
    const std::uint8_t holding_faces =
        anchors.faces ? anchors.faces : static_cast<std::uint8_t>(anchors.free_border ? 0 : 63);
    if (holding_faces && (faces_of(voxel, grid().volume_size()) & holding_faces)) return true;
    return fixed_materials && materials.table().fixed(materials.at(voxel));
  }

  void prepare_gains(std::int64_t b) {
    BrickMotion& m = motion(b);
    m.gain.assign(kBrickVoxels, 0.0f);
    Halo& halo = halos.front();
    gather_compliance(b, halo);
    const VoxelBox box = grid().box(grid().brick(b));
    const ElementSet::Mask* mask = held.brick(b);
    const bool fixed_materials = materials.table().any_fixed();
    for (int z = box.lo.z; z < box.hi.z; ++z) {
      for (int y = box.lo.y; y < box.hi.y; ++y) {
        for (int x = box.lo.x; x < box.hi.x; ++x) {
          if (is_held({x, y, z}, mask, fixed_materials)) continue;
          const int at = halo_index(x & 31, y & 31, z & 31);
          double sum = 0.0;
          for (const Spring& spring : springs) {
            sum += 2.0 / (double{halo.compliance[static_cast<std::size_t>(at)]} +
                          halo.compliance[static_cast<std::size_t>(at + spring.halo_step)]);
          }
          if (sum <= 0.0) continue;
          m.gain[static_cast<std::size_t>(element_in_brick({x, y, z}))] =
              static_cast<float>(options.step / sum);
          ++m.free_elements;
        }
      }
    }
    m.active = m.free_elements > 0;
  }

  // Fills a halo array from the brick and its 26 neighbours; source(b) is a brick's array or null
  // for one that holds `absent` everywhere.
  template <class Source>
  void gather(std::int64_t b, std::vector<float>& out, float beyond, Source&& source) const {
    const BrickIndex brick = grid().brick(b);
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const BrickIndex there = brick + BrickIndex(dx, dy, dz);
          const float* from = grid().contains(there) ? source(grid().linear(there)) : nullptr;
          // Where this neighbour's elements lie in the halo, and in itself.
          const auto range = [](int d) {
            return d < 0 ? std::pair{0, 1} : d == 0 ? std::pair{1, 33} : std::pair{33, 34};
          };
          const auto [x0, x1] = range(dx);
          const auto [y0, y1] = range(dy);
          const auto [z0, z1] = range(dz);
          for (int z = z0; z < z1; ++z) {
            for (int y = y0; y < y1; ++y) {
              float* row =
                  &out[static_cast<std::size_t>(z * kHaloPlane + y * kSpringHaloEdge + x0)];
              if (!from) {
                std::fill(row, row + (x1 - x0), beyond);
                continue;
              }
              const float* other = from +
                                   (((z - 1) & 31) * kBrickEdge + ((y - 1) & 31)) * kBrickEdge +
                                   ((x0 - 1) & 31);
              std::copy(other, other + (x1 - x0), row);
            }
          }
        }
      }
    }
  }

  void gather_compliance(std::int64_t b, Halo& halo) const {
    gather(b, halo.compliance, kNoSpring, [&](std::int64_t n) {
      return bricks_springs[static_cast<std::size_t>(n)]->compliance.data();
    });
  }

  void gather_all(std::int64_t b, Halo& halo) const {
    gather_compliance(b, halo);
    for (int c = 0; c < 3; ++c) {
      gather(b, halo.u_mm[c], 0.0f, [&](std::int64_t n) -> const float* {
        const BrickMotion* m = motion_or_none(n);
        return m ? m->u_mm[c].data() : nullptr;
      });
    }
  }

  // One Jacobi step of a brick, from the old state of all into its own next state.
  void sweep(std::int64_t b, Halo& halo) {
    BrickMotion& m = motion(b);
    gather_all(b, halo);
    const auto blend = static_cast<float>(options.rest_vector_blend);
    const glm::vec3 voxel_from_mm = glm::vec3(1.0 / spacing_mm);
    const Size3 extent = grid().box(grid().brick(b)).size();
    m.largest_move = 0.0f;
    m.face_move.fill(0.0f);
    for (int z = 0; z < extent.z; ++z) {
      for (int y = 0; y < extent.y; ++y) {
        const auto center = static_cast<std::size_t>(halo_index(0, y, z));
        const HaloRow in{&halo.u_mm[0][center], &halo.u_mm[1][center], &halo.u_mm[2][center],
                         &halo.compliance[center]};
        RowForces force;
        add_up_forces(in, springs, blend, force);
        const auto row = static_cast<std::size_t>((z * kBrickEdge + y) * kBrickEdge);
        float row_move[kBrickEdge];
        for (std::size_t x = 0; x < kBrickEdge; ++x) {
          const float gain = m.gain[row + x];
          const float sx = gain * force.x[x];
          const float sy = gain * force.y[x];
          const float sz = gain * force.z[x];
          m.next_mm[0][row + x] = in.u_x_mm[x] + sx;
          m.next_mm[1][row + x] = in.u_y_mm[x] + sy;
          m.next_mm[2][row + x] = in.u_z_mm[x] + sz;
          row_move[x] = std::max({std::abs(sx) * voxel_from_mm.x, std::abs(sy) * voxel_from_mm.y,
                                  std::abs(sz) * voxel_from_mm.z});
        }
        float largest = 0.0f;
        for (int x = 0; x < extent.x; ++x) largest = std::max(largest, row_move[x]);
        m.largest_move = std::max(m.largest_move, largest);
        const auto note = [&](int face, float move) {
          float& most = m.face_move[static_cast<std::size_t>(face)];
          most = std::max(most, move);
        };
        note(0, row_move[0]);
        note(1, row_move[extent.x - 1]);
        if (y == 0) note(2, largest);
        if (y == extent.y - 1) note(3, largest);
        if (z == 0) note(4, largest);
        if (z == extent.z - 1) note(5, largest);
      }
    }
  }

  // Energy of the springs of a brick's elements. A spring to a brick that takes part is counted
  // half here and half there, one to a brick that does not is counted whole.
  double energy_of(std::int64_t b, Halo& halo) const {
    gather_all(b, halo);
    const double blend = options.rest_vector_blend;
    const Size3 extent = grid().box(grid().brick(b)).size();
    const BrickIndex brick = grid().brick(b);
    double sum = 0.0;
    for (int z = 0; z < extent.z; ++z) {
      for (int y = 0; y < extent.y; ++y) {
        for (int x = 0; x < extent.x; ++x) {
          const int at = halo_index(x, y, z);
          const bool inner = x > 0 && y > 0 && z > 0 && x < kBrickEdge - 1 && y < kBrickEdge - 1 &&
                             z < kBrickEdge - 1;
          for (const Spring& spring : springs) {
            const auto i = static_cast<std::size_t>(at);
            const auto j = static_cast<std::size_t>(at + spring.halo_step);
            const double compliance = double{halo.compliance[i]} + halo.compliance[j];
            if (std::isinf(compliance)) continue;
            const glm::dvec3 du(double{halo.u_mm[0][i]} - halo.u_mm[0][j],
                                double{halo.u_mm[1][i]} - halo.u_mm[1][j],
                                double{halo.u_mm[2][i]} - halo.u_mm[2][j]);
            if (du == glm::dvec3(0.0)) continue;
            const double stretch = glm::length(glm::dvec3(spring.rest_mm) + du) - spring.length_mm;
            double share = 0.5;
            if (!inner) {
              const VoxelIndex beside = VoxelIndex(x, y, z) + spring.offset;
              const BrickIndex there = brick + BrickGrid::brick_of(beside);
              if (!motion_or_none(grid().linear(there))) share = 1.0;
            }
            sum += share * (1.0 / compliance) *
                   ((1.0 - blend) * stretch * stretch + blend * glm::dot(du, du));
          }
        }
      }
    }
    return sum;
  }

  double energy() {
    const trace::Span span("relaxation energy");
    std::vector<double> energies(moving.size());
    pool.for_each(static_cast<std::int64_t>(moving.size()), [&](std::int64_t i, int worker) {
      energies[static_cast<std::size_t>(i)] =
          energy_of(moving[static_cast<std::size_t>(i)], halos[static_cast<std::size_t>(worker)]);
    });
    double sum = 0.0;  // in the order of the bricks: the same for any number of threads
    for (const double e : energies) sum += e;
    return sum;
  }

  void refresh_active() {
    active.clear();
    for (const std::int64_t b : moving) {
      if (motion(b).active && motion(b).free_elements > 0) active.push_back(b);
    }
  }

  // Lets bricks rest that hardly moved in the last sweep and wakes those beside a face that did.
  void update_active() {
    const auto resting = static_cast<float>(resting_move_voxels);
    std::vector<std::int64_t> wake;
    for (const std::int64_t b : active) {
      BrickMotion& m = motion(b);
      m.active = m.largest_move > resting;
      const BrickIndex brick = grid().brick(b);
      for (int face = 0; face < 6; ++face) {
        if (m.face_move[static_cast<std::size_t>(face)] <= resting) continue;
        BrickIndex there = brick;
        there[face / 2] += face % 2 ? 1 : -1;
        if (grid().contains(there)) wake.push_back(grid().linear(there));
      }
    }
    for (const std::int64_t b : wake) {
      take_in(b);
      motion(b).active = motion(b).free_elements > 0;
    }
    refresh_active();
  }

  void iterate() {
    if (progress.finished()) return;
    const trace::Span span("relaxation sweep");
    pool.for_each(static_cast<std::int64_t>(active.size()), [&](std::int64_t i, int worker) {
      sweep(active[static_cast<std::size_t>(i)], halos[static_cast<std::size_t>(worker)]);
    });
    float largest = 0.0f;
    for (const std::int64_t b : active) {
      BrickMotion& m = motion(b);
      for (int c = 0; c < 3; ++c) std::swap(m.u_mm[c], m.next_mm[c]);
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
    const std::size_t bricks_before = moving.size();
    update_active();
    if (active.empty()) {
      // All rest by the threshold, yet the estimate says there is some way to go: look closer.
      resting_move_voxels = std::max(resting_move_voxels * 0.1, kSmallestMove_voxels);
      for (const std::int64_t b : moving) motion(b).active = true;
      refresh_active();
    }
    // Springs newly counted in full would look like a rise.
    if (moving.size() != bricks_before) progress.energy_last = energy();
  }

  Lattice lattice() {
    const trace::Span span("relaxation publish");
    std::vector<std::int64_t> changed;
    for (const std::int64_t b : moving) {
      if (motion(b).changed) changed.push_back(b);
    }
    std::vector<Lattice::Change> changes(changed.size());
    pool.for_each(static_cast<std::int64_t>(changed.size()), [&](std::int64_t i, int) {
      const std::int64_t b = changed[static_cast<std::size_t>(i)];
      changes[static_cast<std::size_t>(i)] = {b, rounded(b)};
    });
    for (const std::int64_t b : changed) motion(b).changed = false;
    published.set(changes);
    return published;
  }

  LatticeBrick::Pointer rounded(std::int64_t b) const {
    const BrickMotion& m = *motion_or_none(b);
    const LatticeBrick* from = start.brick(b);
    const auto brick = std::make_unique<BrickDisplacements>();
    for (int c = 0; c < 3; ++c) {
      const auto units_from_mm = static_cast<float>(kUnitsPerVoxel / spacing_mm[c]);
      for (int row = 0; row < kBrickEdge * kBrickEdge; ++row) {
        std::int32_t held_at[kBrickEdge] = {};
        if (from) from->read_row(c, row, held_at);
        for (int x = 0; x < kBrickEdge; ++x) {
          // What is held keeps its bits: a float cannot hold every fixed-point displacement.
          const auto e = static_cast<std::size_t>(row * kBrickEdge + x);
          brick->u[c][e] =
              m.gain[e] == 0.0f
                  ? held_at[x]
                  : static_cast<std::int32_t>(std::lrint(m.u_mm[c][e] * units_from_mm));
        }
      }
    }
    return LatticeBrick::create(grid().box(grid().brick(b)), *brick);
  }
};

Relaxation::Relaxation(const Lattice& start, const MaterialField& materials, const ElementSet& held,
                       AnchorRules anchors, WorkerPool& pool, const RelaxationOptions& options)
    : state_(std::make_unique<State>(start, materials, held, anchors, pool, options)) {}
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

std::int64_t Relaxation::bytes() const {
  constexpr std::int64_t kMotion = 7 * kBrickVoxels * std::int64_t{sizeof(float)};
  constexpr std::int64_t kSprings = kBrickVoxels * std::int64_t{sizeof(float)};
  std::int64_t springs = 0;
  for (const auto& brick : state_->bricks_springs) springs += brick ? kSprings : 0;
  return springs + static_cast<std::int64_t>(state_->moving.size()) * kMotion;
}

}  // namespace maille
