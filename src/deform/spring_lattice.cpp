#include "deform/spring_lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "deform/missing_springs.h"

namespace maille {
namespace {

constexpr int kHaloPlane = kSpringHaloEdge * kSpringHaloEdge;
constexpr std::size_t kHaloElements = std::size_t{kHaloPlane} * kSpringHaloEdge;
constexpr float kNoSpring = std::numeric_limits<float>::infinity();  // as a compliance

bool any_of_row(const std::uint32_t* missing) {
  std::uint32_t any = 0;
  for (int x = 0; x < kBrickEdge; ++x) any |= missing[x];
  return any != 0;
}

}  // namespace

void SpringBrick::take_step() {
  for (int c = 0; c < 3; ++c) std::swap(u_mm[c], next_mm[c]);
}

SpringLattice::Halo::Halo() : compliance(kHaloElements) {
  for (auto& u : u_mm) u.resize(kHaloElements);
}

SpringLattice::SpringLattice(const Problem& problem, int workers)
    : start_(problem.start),
      materials_(problem.materials),
      cuts_(problem.cuts),
      held_(problem.held),
      anchors_(problem.anchors),
      step_(problem.step),
      rest_vector_blend_(problem.rest_vector_blend),
      spacing_mm_(problem.materials.spacing_mm()),
      springs_(springs_of(problem.materials.spacing_mm())),
      compliances_(static_cast<std::size_t>(problem.start.grid().count())),
      bricks_(static_cast<std::size_t>(problem.start.grid().count())),
      halos_(static_cast<std::size_t>(workers)) {}

template <class F>
void SpringLattice::for_each_neighbour(BrickIndex brick, F&& f) const {
  for (int z = -1; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        const BrickIndex there = brick + BrickIndex(x, y, z);
        if (grid().contains(there)) f(grid().linear(there));
      }
    }
  }
}

void SpringLattice::take_in_with_neighbours(std::int64_t b) {
  for_each_neighbour(grid().brick(b), [&](std::int64_t n) { take_in(n); });
}

void SpringLattice::take_in(std::int64_t b) {
  if (bricks_[static_cast<std::size_t>(b)]) return;
  for_each_neighbour(grid().brick(b), [&](std::int64_t n) { prepare_compliance(n); });
  auto brick = std::make_unique<SpringBrick>();
  const LatticeBrick* from = start_.brick(b);
  for (int c = 0; c < 3; ++c) {
    brick->u_mm[c].assign(kBrickVoxels, 0.0f);
    if (from) {
      const double mm_from_units = spacing_mm_[c] / kUnitsPerVoxel;
      for (int row = 0; row < kBrickEdge * kBrickEdge; ++row) {
        std::int32_t u[kBrickEdge];
        from->read_row(c, row, u);
        for (int x = 0; x < kBrickEdge; ++x) {
          brick->u_mm[c][static_cast<std::size_t>(row * kBrickEdge + x)] =
              static_cast<float>(u[x] * mm_from_units);
        }
      }
    }
    brick->next_mm[c] = brick->u_mm[c];
  }
  bricks_[static_cast<std::size_t>(b)] = std::move(brick);
  prepare_gains(b);
  taking_part_.insert(std::lower_bound(taking_part_.begin(), taking_part_.end(), b), b);
}

void SpringLattice::prepare_compliance(std::int64_t b) {
  auto& compliance = compliances_[static_cast<std::size_t>(b)];
  if (!compliance.empty()) return;
  compliance.assign(kBrickVoxels, kNoSpring);
  const VoxelBox box = grid().box(grid().brick(b));
  std::vector<MaterialId> ids(static_cast<std::size_t>(voxel_count(box.size())));
  materials_.read(box, ids);
  auto id = ids.begin();
  for (int z = box.lo.z; z < box.hi.z; ++z) {
    for (int y = box.lo.y; y < box.hi.y; ++y) {
      for (int x = box.lo.x; x < box.hi.x; ++x) {
        compliance[static_cast<std::size_t>(element_in_brick({x, y, z}))] =
            materials_.table().compliance(*id++);
      }
    }
  }
}

bool SpringLattice::is_held(VoxelIndex voxel, const ElementSet::Mask* mask,
                            bool fixed_materials) const {
  if (mask && mask->test(static_cast<std::size_t>(element_in_brick(voxel)))) return true;
  const std::uint8_t holding_faces =
      anchors_.faces ? anchors_.faces : static_cast<std::uint8_t>(anchors_.free_border ? 0 : 63);
  if (holding_faces && (faces_of(voxel, grid().volume_size()) & holding_faces)) return true;
  return fixed_materials && materials_.table().fixed(materials_.at(voxel));
}

void SpringLattice::prepare_gains(std::int64_t b) {
  SpringBrick& m = brick(b);
  m.gain.assign(kBrickVoxels, 0.0f);
  m.missing = missing_springs(cuts_, b, springs_);
  Halo& halo = halos_.front();
  gather_compliance(b, halo);
  const VoxelBox box = grid().box(grid().brick(b));
  const ElementSet::Mask* mask = held_.brick(b);
  const bool fixed_materials = materials_.table().any_fixed();
  for (int z = box.lo.z; z < box.hi.z; ++z) {
    for (int y = box.lo.y; y < box.hi.y; ++y) {
      for (int x = box.lo.x; x < box.hi.x; ++x) {
        if (is_held({x, y, z}, mask, fixed_materials)) continue;
        const int at = halo_index(x & 31, y & 31, z & 31);
        const auto e = static_cast<std::size_t>(element_in_brick({x, y, z}));
        const std::uint32_t gone = m.missing.empty() ? 0 : m.missing[e];
        double sum = 0.0;
        for (std::size_t s = 0; s < springs_.size(); ++s) {
          if ((gone >> s) & 1) continue;
          sum += 2.0 / (double{halo.compliance[static_cast<std::size_t>(at)]} +
                        halo.compliance[static_cast<std::size_t>(at + springs_[s].halo_step)]);
        }
        if (sum <= 0.0) continue;  // an element alone stays where it is
        m.gain[e] = static_cast<float>(step_ / sum);
        ++m.free_elements;
      }
    }
  }
  m.active = m.free_elements > 0;
}

// Fills a halo array from the brick and its 26 neighbours; source(b) is a brick's array or null
// for one that holds `beyond` everywhere.
template <class Source>
void SpringLattice::gather(std::int64_t b, std::vector<float>& out, float beyond,
                           Source&& source) const {
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
            float* row = &out[static_cast<std::size_t>(z * kHaloPlane + y * kSpringHaloEdge + x0)];
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

void SpringLattice::gather_compliance(std::int64_t b, Halo& halo) const {
  gather(b, halo.compliance, kNoSpring,
         [&](std::int64_t n) { return compliances_[static_cast<std::size_t>(n)].data(); });
}

void SpringLattice::gather_all(std::int64_t b, Halo& halo) const {
  gather_compliance(b, halo);
  for (int c = 0; c < 3; ++c) {
    gather(b, halo.u_mm[c], 0.0f, [&](std::int64_t n) -> const float* {
      const SpringBrick* m = brick_or_none(n);
      return m ? m->u_mm[c].data() : nullptr;
    });
  }
}

void SpringLattice::sweep(std::int64_t b, int worker) {
  Halo& halo = halos_[static_cast<std::size_t>(worker)];
  SpringBrick& m = brick(b);
  gather_all(b, halo);
  const auto blend = static_cast<float>(rest_vector_blend_);
  const glm::vec3 voxel_from_mm = glm::vec3(1.0 / spacing_mm_);
  const Size3 extent = grid().box(grid().brick(b)).size();
  m.largest_move = 0.0f;
  m.face_move.fill(0.0f);
  for (int z = 0; z < extent.z; ++z) {
    for (int y = 0; y < extent.y; ++y) {
      const auto center = static_cast<std::size_t>(halo_index(0, y, z));
      const HaloRow in{&halo.u_mm[0][center], &halo.u_mm[1][center], &halo.u_mm[2][center],
                       &halo.compliance[center]};
      const auto row = static_cast<std::size_t>((z * kBrickEdge + y) * kBrickEdge);
      RowForces force;
      if (!m.missing.empty() && any_of_row(&m.missing[row])) {
        add_up_forces_left(in, springs_, blend, &m.missing[row], force);
      } else {
        add_up_forces(in, springs_, blend, force);
      }
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

double SpringLattice::energy_of(std::int64_t b, int worker) {
  Halo& halo = halos_[static_cast<std::size_t>(worker)];
  gather_all(b, halo);
  const std::vector<std::uint32_t>& missing = brick(b).missing;
  const double blend = rest_vector_blend_;
  const BrickIndex index = grid().brick(b);
  const Size3 extent = grid().box(index).size();
  double sum = 0.0;
  for (int z = 0; z < extent.z; ++z) {
    for (int y = 0; y < extent.y; ++y) {
      for (int x = 0; x < extent.x; ++x) {
        const int at = halo_index(x, y, z);
        const std::uint32_t gone =
            missing.empty() ? 0 : missing[static_cast<std::size_t>(element_in_brick({x, y, z}))];
        const bool inner = x > 0 && y > 0 && z > 0 && x < kBrickEdge - 1 && y < kBrickEdge - 1 &&
                           z < kBrickEdge - 1;
        for (std::size_t s = 0; s < springs_.size(); ++s) {
          if ((gone >> s) & 1) continue;
          const Spring& spring = springs_[s];
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
            const BrickIndex there = index + BrickGrid::brick_of(beside);
            if (!brick_or_none(grid().linear(there))) share = 1.0;
          }
          sum += share * (1.0 / compliance) *
                 ((1.0 - blend) * stretch * stretch + blend * glm::dot(du, du));
        }
      }
    }
  }
  return sum;
}

LatticeBrick::Pointer SpringLattice::rounded(std::int64_t b) const {
  const SpringBrick& m = *brick_or_none(b);
  const LatticeBrick* from = start_.brick(b);
  const auto brick = std::make_unique<BrickDisplacements>();
  for (int c = 0; c < 3; ++c) {
    const auto units_from_mm = static_cast<float>(kUnitsPerVoxel / spacing_mm_[c]);
    for (int row = 0; row < kBrickEdge * kBrickEdge; ++row) {
      std::int32_t held_at[kBrickEdge] = {};
      if (from) from->read_row(c, row, held_at);
      for (int x = 0; x < kBrickEdge; ++x) {
        // What is held keeps its bits: a float cannot hold every fixed-point displacement.
        const auto e = static_cast<std::size_t>(row * kBrickEdge + x);
        brick->u[c][e] = m.gain[e] == 0.0f
                             ? held_at[x]
                             : static_cast<std::int32_t>(std::lrint(m.u_mm[c][e] * units_from_mm));
      }
    }
  }
  return LatticeBrick::create(grid().box(grid().brick(b)), *brick);
}

std::int64_t SpringLattice::bytes() const {
  std::int64_t sum = 0;
  for (const auto& c : compliances_) sum += static_cast<std::int64_t>(c.size() * sizeof(float));
  for (const std::int64_t b : taking_part_) {
    constexpr std::int64_t kStates = 7 * kBrickVoxels * std::int64_t{sizeof(float)};
    const auto missing = brick_or_none(b)->missing.size() * sizeof(std::uint32_t);
    sum += kStates + static_cast<std::int64_t>(missing);
  }
  return sum;
}

}  // namespace maille
