#include "deform/lattice.h"

#include <algorithm>
#include <limits>

#include "material/material_field.h"

namespace maille {

void LatticeBrick::update_bounds(const VoxelBox& box) {
  const Size3 extent = box.size();
  lowest = glm::ivec3(std::numeric_limits<std::int32_t>::max());
  highest = glm::ivec3(std::numeric_limits<std::int32_t>::min());
  VoxelIndex first = extent;
  VoxelIndex last{-1};
  for (int z = 0; z < extent.z; ++z) {
    for (int y = 0; y < extent.y; ++y) {
      std::int32_t any_u[kBrickEdge] = {};
      for (int c = 0; c < 3; ++c) {
        const std::int32_t* row = &u[c][(z * kBrickEdge + y) * kBrickEdge];
        std::int32_t any = 0;
        for (int x = 0; x < extent.x; ++x) {
          any |= row[x];
          any_u[x] |= row[x];
        }
        // Most rows of most bricks rest.
        const auto [least, most] =
            any ? std::minmax_element(row, row + extent.x) : std::pair(row, row);
        lowest[c] = std::min(lowest[c], *least);
        highest[c] = std::max(highest[c], *most);
      }
      const auto moves = [](std::int32_t bits) { return bits != 0; };
      const auto begin = std::find_if(any_u, any_u + extent.x, moves);
      if (begin == any_u + extent.x) continue;
      int end = extent.x - 1;
      while (any_u[end] == 0) --end;
      first = glm::min(first, VoxelIndex(static_cast<int>(begin - any_u), y, z));
      last = glm::max(last, VoxelIndex(end, y, z));
    }
  }
  moved = last.x < 0 ? VoxelBox{} : VoxelBox{box.lo + first, box.lo + last + 1};
}

void Lattice::set(std::int64_t linear, std::shared_ptr<const LatticeBrick> brick) {
  if (brick && brick->at_rest()) brick = nullptr;
  bricks_[static_cast<std::size_t>(linear)] = std::move(brick);
}

glm::ivec3 Lattice::u(VoxelIndex voxel) const {
  const LatticeBrick* b = brick(grid_.linear(BrickGrid::brick_of(voxel)));
  if (!b) return glm::ivec3(0);
  const int element = element_in_brick(voxel);
  return {b->u[0][element], b->u[1][element], b->u[2][element]};
}

std::int64_t Lattice::brick_count() const {
  return std::count_if(bricks_.begin(), bricks_.end(), [](const auto& b) { return b != nullptr; });
}

Violations violations_of(const Lattice& lattice, const MaterialField& materials) {
  const BrickGrid& grid = lattice.grid();
  const Size3 size = grid.volume_size();
  Violations found;
  std::int64_t worst = 0;
  std::vector<MaterialId> ids(
      static_cast<std::size_t>((kBrickEdge + 1) * (kBrickEdge + 1) * (kBrickEdge + 1)));
  for (std::int64_t b = 0; b < grid.count(); ++b) {
    const BrickIndex brick = grid.brick(b);
    // A brick's links are those that start in it and run to the next element along each axis: they
    // count if either end may have moved.
    bool may_differ = lattice.brick(b) != nullptr;
    for (int axis = 0; axis < 3; ++axis) {
      BrickIndex next = brick;
      ++next[axis];
      may_differ = may_differ || (grid.contains(next) && lattice.brick(grid.linear(next)));
    }
    if (!may_differ) continue;
    const VoxelBox box = grid.box(brick);
    const VoxelBox with_next = {box.lo, glm::min(box.hi + 1, size)};
    materials.read(with_next, ids);
    const Size3 extent = with_next.size();
    const auto id = [&](VoxelIndex v) {
      return ids[static_cast<std::size_t>(linear_index(v - with_next.lo, extent))];
    };
    for (int z = box.lo.z; z < box.hi.z; ++z) {
      for (int y = box.lo.y; y < box.hi.y; ++y) {
        for (int x = box.lo.x; x < box.hi.x; ++x) {
          const VoxelIndex i{x, y, z};
          const glm::ivec3 u_i = lattice.u(i);
          for (int axis = 0; axis < 3; ++axis) {
            VoxelIndex j = i;
            if (++j[axis] >= size[axis]) continue;
            const LinkLimits& limits = materials.table().link(id(i), id(j));
            const glm::ivec3 u_j = lattice.u(j);
            std::int64_t excess = 0;
            for (int c = 0; c < 3; ++c) {
              const std::int64_t d = std::int64_t{u_j[c]} - u_i[c];
              excess = std::max({excess, d - limits.upper[axis][c], limits.lower[axis][c] - d});
            }
            found.links += excess > 0;
            worst = std::max(worst, excess);
          }
        }
      }
    }
  }
  found.worst_voxels = static_cast<double>(worst) / kUnitsPerVoxel;
  return found;
}

}  // namespace maille
