#include "resample/reach.h"

#include <algorithm>
#include <bit>
#include <optional>

#include "resample/brick_set.h"
#include "resample/near_bricks.h"

namespace maille {
namespace {

int floor_voxels(int units) { return units >> 9; }
int ceil_voxels(int units) { return -((-units) >> 9); }
static_assert(kUnitsPerVoxel == 1 << 9);

// The elements of a brick with links or existence that differ; null: nothing is cut or carved.
VoxelBox changed_elements(const VoxelBox& box, const CutBrick* before, const CutBrick* after) {
  static const CutBrick kWhole;
  const CutBrick& a = before ? *before : kWhole;
  const CutBrick& b = after ? *after : kWhole;
  VoxelBox changed{box.hi, box.lo};
  for (int z = box.lo.z; z < box.hi.z; ++z) {
    for (int y = box.lo.y; y < box.hi.y; ++y) {
      const auto row = static_cast<std::size_t>((z & 31) * kBrickEdge + (y & 31));
      std::uint32_t bits = a.carved[row] ^ b.carved[row];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        bits |= a.removed[axis][row] ^ b.removed[axis][row];
      }
      if (bits == 0) continue;
      changed.lo = glm::min(changed.lo, VoxelIndex(box.lo.x + std::countr_zero(bits), y, z));
      changed.hi = glm::max(changed.hi, VoxelIndex(box.lo.x + std::bit_width(bits), y + 1, z + 1));
    }
  }
  return intersection(changed, box);
}

// Of all cells at a box of elements or at the links from them.
Reach reach_around(const Lattice& lattice, const VoxelBox& elements) {
  const BrickGrid& grid = lattice.grid();
  Reach reach{{elements.lo - 1, elements.hi}};
  const BrickIndex lo = BrickGrid::brick_of(glm::max(elements.lo - 1, VoxelIndex(0)));
  const BrickIndex hi = BrickGrid::brick_of(glm::min(elements.hi, grid.volume_size() - 1));
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x) {
        const LatticeBrick* brick = lattice.brick(grid.linear({x, y, z}));
        if (!brick) continue;
        reach.u_lowest = glm::min(reach.u_lowest, brick->lowest());
        reach.u_highest = glm::max(reach.u_highest, brick->highest());
      }
    }
  }
  return reach;
}

}  // namespace

VoxelBox Reach::covered() const {
  VoxelBox box;
  for (int c = 0; c < 3; ++c) {
    box.lo[c] = cells.lo[c] + floor_voxels(u_lowest[c]);
    box.hi[c] = cells.hi[c] + ceil_voxels(u_highest[c]) + 1;
  }
  return box;
}

Reach reach_of(const Lattice& lattice, std::int64_t linear) {
  const BrickGrid& grid = lattice.grid();
  const LatticeBrick& brick = *lattice.brick(linear);
  const BrickIndex index = grid.brick(linear);
  const VoxelBox box = grid.box(index);
  Reach reach{{brick.moved().lo - 1, brick.moved().hi}, brick.lowest(), brick.highest()};
  // The other corners of these cells lie one element around the moved box. Those in this brick are
  // within its bounds; the neighbours on the sides that the box touches have bounds of their own.
  const glm::ivec3 from = -glm::ivec3(glm::equal(brick.moved().lo, box.lo));
  const glm::ivec3 to = glm::ivec3(glm::equal(brick.moved().hi, box.hi));
  for (int z = from.z; z <= to.z; ++z) {
    for (int y = from.y; y <= to.y; ++y) {
      for (int x = from.x; x <= to.x; ++x) {
        const BrickIndex there = index + BrickIndex(x, y, z);
        if (!grid.contains(there)) continue;
        const LatticeBrick* neighbour = lattice.brick(grid.linear(there));
        reach.u_lowest = glm::min(reach.u_lowest, neighbour ? neighbour->lowest() : glm::ivec3(0));
        reach.u_highest =
            glm::max(reach.u_highest, neighbour ? neighbour->highest() : glm::ivec3(0));
      }
    }
  }
  return reach;
}

std::vector<std::int64_t> dirty_bricks(const Lattice& before, const Cuts& cuts_before,
                                       const Lattice& after, const Cuts& cuts_after,
                                       glm::dvec3 spacing_mm, const VoxelBox& extent,
                                       ResampleMethod method) {
  const BrickGrid& grid = after.grid();
  BrickSet dirty(BrickGrid(extent.size()));
  const auto add = [&](const VoxelBox& voxels) {
    dirty.add_over(shifted(intersection(voxels, extent), -extent.lo));
  };
  // By their values at cells' corners, or as the nearest too.
  const bool by_cells = method == ResampleMethod::linear || method == ResampleMethod::barycentric;
  struct State {
    const Lattice& lattice;
    std::optional<NearBricks> near;
  };
  State states[] = {{before, std::nullopt}, {after, std::nullopt}};
  const auto add_covered = [&](const Reach& reach, State& state) {
    const VoxelBox covered = reach.covered();
    if (by_cells) return add(covered);
    if (!state.near) state.near.emplace(state.lattice, spacing_mm, extent);
    state.near->add(covered, dirty);
  };
  Lattice::for_each_difference(before, after, [&](std::int64_t b) {
    for (State& state : states) {
      const LatticeBrick* const brick = state.lattice.brick(b);
      if (!brick) continue;
      add(brick->moved());  // elements that come to rest own their voxels again
      add_covered(reach_of(state.lattice, b), state);
    }
  });
  Cuts::for_each_difference(cuts_before, cuts_after, [&](std::int64_t b) {
    const VoxelBox changed =
        changed_elements(grid.box(grid.brick(b)), cuts_before.brick(b), cuts_after.brick(b));
    if (changed.empty()) return;
    add(grid.box(grid.brick(b)));  // elements at rest own their voxels until they are carved
    for (State& state : states) {
      const Reach reach = reach_around(state.lattice, changed);
      const bool rests = reach.u_lowest == glm::ivec3(0) && reach.u_highest == glm::ivec3(0);
      if (!rests) add_covered(reach, state);
    }
  });
  return dirty.list();
}

}  // namespace maille
