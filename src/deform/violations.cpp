#include "deform/violations.h"

#include <algorithm>
#include <vector>

namespace maille {
namespace {

// The displacements of a brick's elements and of the next ones along each axis.
class BrickCorner {
 public:
  void read(const Lattice& lattice, const VoxelBox& with_next) {
    extent_ = with_next.size();
    for (auto& u : u_) u.resize(static_cast<std::size_t>(voxel_count(extent_)));
    std::size_t at = 0;
    for (int z = with_next.lo.z; z < with_next.hi.z; ++z) {
      for (int y = with_next.lo.y; y < with_next.hi.y; ++y) {
        for (int x = with_next.lo.x; x < with_next.hi.x;) {
          const BrickIndex brick = BrickGrid::brick_of({x, y, z});
          const LatticeBrick* from = lattice.brick(lattice.grid().linear(brick));
          const int row = element_in_brick({0, y, z}) / kBrickEdge;
          const int count = std::min(with_next.hi.x, (x | 31) + 1) - x;
          for (int c = 0; c < 3; ++c) {
            std::int32_t u[kBrickEdge] = {};
            if (from) from->read_row(c, row, u);
            std::copy_n(u + (x & 31), count, &u_[c][at]);
          }
          at += static_cast<std::size_t>(count);
          x += count;
        }
      }
    }
  }

  glm::ivec3 u(VoxelIndex in_box) const {
    const auto i = static_cast<std::size_t>(linear_index(in_box, extent_));
    return {u_[0][i], u_[1][i], u_[2][i]};
  }

 private:
  Size3 extent_{0};
  std::vector<std::int32_t> u_[3];
};

}  // namespace

Violations violations_of(const Lattice& lattice, const MaterialField& materials) {
  const BrickGrid& grid = lattice.grid();
  const Size3 size = grid.volume_size();
  Violations found;
  std::int64_t worst = 0;
  std::vector<MaterialId> ids(
      static_cast<std::size_t>((kBrickEdge + 1) * (kBrickEdge + 1) * (kBrickEdge + 1)));
  BrickCorner corner;
  // A brick's links are those that start in it and run to the next element along each axis: they
  // count if either end may have moved.
  std::vector<std::int64_t> bricks;
  lattice.for_each_brick([&](std::int64_t b, const LatticeBrick&) {
    bricks.push_back(b);
    for (int axis = 0; axis < 3; ++axis) {
      BrickIndex before = grid.brick(b);
      if (--before[axis] >= 0) bricks.push_back(grid.linear(before));
    }
  });
  std::sort(bricks.begin(), bricks.end());
  bricks.erase(std::unique(bricks.begin(), bricks.end()), bricks.end());
  for (const std::int64_t b : bricks) {
    const VoxelBox box = grid.box(grid.brick(b));
    const VoxelBox with_next = {box.lo, glm::min(box.hi + 1, size)};
    const Size3 extent = with_next.size();
    materials.read(with_next, ids);
    corner.read(lattice, with_next);
    const auto id = [&](VoxelIndex v) {
      return ids[static_cast<std::size_t>(linear_index(v, extent))];
    };
    for (int z = 0; z < box.size().z; ++z) {
      for (int y = 0; y < box.size().y; ++y) {
        for (int x = 0; x < box.size().x; ++x) {
          const VoxelIndex i{x, y, z};
          const glm::ivec3 u_i = corner.u(i);
          for (int axis = 0; axis < 3; ++axis) {
            VoxelIndex j = i;
            if (++j[axis] >= extent[axis]) continue;
            const LinkLimits limits = materials.table().link(id(i), id(j));
            const glm::ivec3 u_j = corner.u(j);
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
