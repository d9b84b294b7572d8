#include "resample/reach.h"

#include <algorithm>

namespace maille {
namespace {

int floor_voxels(int units) { return units >> 9; }
int ceil_voxels(int units) { return -((-units) >> 9); }
static_assert(kUnitsPerVoxel == 1 << 9);

}  // namespace

VoxelBox Reach::covered(Size3 volume_size) const {
  VoxelBox box;
  for (int c = 0; c < 3; ++c) {
    box.lo[c] = cells.lo[c] + floor_voxels(u_lowest[c]);
    box.hi[c] = cells.hi[c] + ceil_voxels(u_highest[c]) + 1;
  }
  return intersection(box, {VoxelIndex(0), volume_size});
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

std::vector<std::int64_t> dirty_bricks(const Lattice& before, const Lattice& after) {
  const BrickGrid& grid = after.grid();
  const Size3 size = grid.volume_size();
  std::vector<bool> dirty(static_cast<std::size_t>(grid.count()), false);
  const auto mark = [&](const VoxelBox& voxels) {
    if (voxels.empty()) return;
    const BrickIndex lo = BrickGrid::brick_of(voxels.lo);
    const BrickIndex hi = BrickGrid::brick_of(voxels.hi - 1);
    for (int z = lo.z; z <= hi.z; ++z) {
      for (int y = lo.y; y <= hi.y; ++y) {
        for (int x = lo.x; x <= hi.x; ++x) {
          dirty[static_cast<std::size_t>(grid.linear({x, y, z}))] = true;
        }
      }
    }
  };
  Lattice::for_each_difference(before, after, [&](std::int64_t b) {
    for (const Lattice* state : {&before, &after}) {
      if (!state->brick(b)) continue;
      mark(state->brick(b)->moved());  // elements that come to rest own their voxels again
      mark(reach_of(*state, b).covered(size));
    }
  });
  std::vector<std::int64_t> list;
  for (std::int64_t b = 0; b < grid.count(); ++b) {
    if (dirty[static_cast<std::size_t>(b)]) list.push_back(b);
  }
  return list;
}

}  // namespace maille
