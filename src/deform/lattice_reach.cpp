#include "deform/lattice_reach.h"

#include <algorithm>
#include <cmath>

namespace maille {
namespace {

bool overlap(const SpaceBox& a, const SpaceBox& b) {
  return glm::all(glm::lessThanEqual(a.lo, b.hi)) && glm::all(glm::lessThanEqual(b.lo, a.hi));
}

// Where the elements of a part of a brick may be.
SpaceBox bounds_of(const LatticeBrick* brick, const VoxelBox& part) {
  SpaceBox bounds{glm::dvec3(part.lo), glm::dvec3(part.hi - 1)};
  if (brick) {
    bounds.lo += glm::dvec3(brick->lowest()) / double{kUnitsPerVoxel};
    bounds.hi += glm::dvec3(brick->highest()) / double{kUnitsPerVoxel};
  }
  return bounds;
}

}  // namespace

VoxelBox rest_range(const SpaceBox& box, const VoxelBox& within, glm::ivec3 lowest,
                    glm::ivec3 highest) {
  VoxelBox range;
  for (int c = 0; c < 3; ++c) {
    const double first = std::ceil(box.lo[c] - highest[c] / double{kUnitsPerVoxel});
    const double last = std::floor(box.hi[c] - lowest[c] / double{kUnitsPerVoxel});
    const double lo = within.lo[c];
    const double hi = within.hi[c];
    // Clamped before it becomes an integer. Written so that NaN is an empty range.
    if (!(first <= last) || !(first < hi) || !(last >= lo)) return {};
    range.lo[c] = static_cast<int>(std::max(first, lo));
    range.hi[c] = static_cast<int>(std::min(last + 1.0, hi));
  }
  return range;
}

SpaceBox bounds_of_links(const Lattice& lattice, std::int64_t brick) {
  const BrickGrid& grid = lattice.grid();
  const BrickIndex index = grid.brick(brick);
  SpaceBox bounds = bounds_of(lattice.brick(brick), grid.box(index));
  for (int axis = 0; axis < 3; ++axis) {
    BrickIndex next = index;
    ++next[axis];
    if (!grid.contains(next)) continue;
    VoxelBox layer = grid.box(next);
    layer.hi[axis] = layer.lo[axis] + 1;
    const SpaceBox there = bounds_of(lattice.brick(grid.linear(next)), layer);
    bounds = {glm::min(bounds.lo, there.lo), glm::max(bounds.hi, there.hi)};
  }
  return bounds;
}

std::vector<std::int64_t> bricks_with_links_in(const SpaceBox& box, const Lattice& lattice) {
  const BrickGrid& grid = lattice.grid();
  std::vector<std::int64_t> bricks;
  // At rest a link is one voxel long.
  const VoxelBox at_rest =
      rest_range({box.lo - 1.0, box.hi + 1.0}, {VoxelIndex(0), grid.volume_size()}, {}, {});
  if (!at_rest.empty()) {
    const BrickIndex first = BrickGrid::brick_of(at_rest.lo);
    const BrickIndex last = BrickGrid::brick_of(at_rest.hi - 1);
    for (int z = first.z; z <= last.z; ++z) {
      for (int y = first.y; y <= last.y; ++y) {
        for (int x = first.x; x <= last.x; ++x) bricks.push_back(grid.linear({x, y, z}));
      }
    }
  }
  for (const std::int64_t b : bricks_with_moved_links(lattice)) bricks.push_back(b);
  std::sort(bricks.begin(), bricks.end());
  bricks.erase(std::unique(bricks.begin(), bricks.end()), bricks.end());
  std::erase_if(bricks, [&](std::int64_t b) { return !overlap(bounds_of_links(lattice, b), box); });
  return bricks;
}

std::vector<std::int64_t> bricks_with_moved_links(const Lattice& lattice) {
  std::vector<std::int64_t> bricks;
  const BrickGrid& grid = lattice.grid();
  lattice.for_each_brick([&](std::int64_t b, const LatticeBrick&) {
    bricks.push_back(b);
    for (int axis = 0; axis < 3; ++axis) {
      BrickIndex before = grid.brick(b);
      if (--before[axis] >= 0) bricks.push_back(grid.linear(before));
    }
  });
  std::sort(bricks.begin(), bricks.end());
  bricks.erase(std::unique(bricks.begin(), bricks.end()), bricks.end());
  return bricks;
}

}  // namespace maille
