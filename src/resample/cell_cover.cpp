#include "resample/cell_cover.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "resample/corner_planes.h"

namespace maille {
namespace {

constexpr int kBlockEdge = 8;  // cells

// Of a reach's cells those whose bounds allow them to touch a box of points (voxel space).
VoxelBox cells_by_bounds(const Reach& reach, glm::dvec3 lo, glm::dvec3 hi) {
  VoxelBox cells;
  for (int c = 0; c < 3; ++c) {
    const double most = static_cast<double>(reach.u_highest[c]) / kUnitsPerVoxel;
    const double least_u = static_cast<double>(reach.u_lowest[c]) / kUnitsPerVoxel;
    const double first = std::ceil(lo[c] - 1.0 - most - 1e-6);
    const double last = std::floor(hi[c] - least_u + 1e-6);
    cells.lo[c] = std::max(reach.cells.lo[c], static_cast<int>(std::clamp(first, -1e9, 1e9)));
    cells.hi[c] = std::min(reach.cells.hi[c], static_cast<int>(std::clamp(last, -1e9, 1e9)) + 1);
  }
  return cells;
}

}  // namespace

CellCover::CellCover(const Lattice& lattice, const Reach& reach, bool cut)
    : lattice_(&lattice),
      reach_(reach),
      cut_(cut),
      covered_(reach.covered()),
      blocks_(std::make_unique<Blocks>()) {
  // Up to here looking at the elements takes longer than those too many that bounds let through.
  constexpr int kClose_voxels = 12;
  const glm::ivec3 spread = reach.u_highest - reach.u_lowest;
  bounds_say_enough_ = std::max({spread.x, spread.y, spread.z}) <= kClose_voxels * kUnitsPerVoxel;
}

const std::vector<CellCover::Block>& CellCover::blocks() const {
  std::call_once(blocks_->once, [&] {
    constexpr float kFar = std::numeric_limits<float>::max();
    // What floats may put on the other side.
    constexpr float kSlack_voxels = 1e-2f;
    const VoxelBox& cells = reach_.cells;
    const glm::ivec3 counts = (cells.size() + (kBlockEdge - 1)) / kBlockEdge;
    const auto count = static_cast<std::size_t>(voxel_count(counts));
    std::vector<Float4> lowest(count, splat(kFar));
    std::vector<Float4> highest(count, splat(-kFar));
    // From where the cells are now, or floats would have no digits left.
    const glm::ivec3 origin = cells.lo + reach_.u_lowest / kUnitsPerVoxel;
    CornerPlanes planes(*lattice_, nullptr, cells, origin);
    for (int z = cells.lo.z; z < cells.hi.z; ++z) {
      planes.advance_to(z);
      for (int y = cells.lo.y; y < cells.hi.y; ++y) {
        const glm::ivec3 row = VoxelIndex(0, y, z) - cells.lo;
        const auto first = static_cast<std::size_t>(
            linear_index({0, row.y / kBlockEdge, row.z / kBlockEdge}, counts));
        CellRow(planes, y, z, cells.size().x).for_each_whole([&](int x, Float4 low, Float4 high) {
          const std::size_t block = first + static_cast<std::size_t>(x / kBlockEdge);
          lowest[block] = least(lowest[block], low);
          highest[block] = greatest(highest[block], high);
        });
      }
    }
    const float slack = kSlack_voxels + (cut_ ? 0.5f : 0.0f);
    for (std::size_t i = 0; i < count; ++i) {
      if (!(highest[i][3] > 0.0f)) continue;  // at rest
      Block block;
      block.cells.lo = cells.lo + voxel_index(static_cast<std::int64_t>(i), counts) * kBlockEdge;
      block.cells.hi = glm::min(block.cells.lo + kBlockEdge, cells.hi);
      for (int c = 0; c < 3; ++c) {
        block.covered.lo[c] = origin[c] + static_cast<int>(std::ceil(lowest[i][c] - slack));
        block.covered.hi[c] = origin[c] + static_cast<int>(std::floor(highest[i][c] + slack)) + 1;
      }
      blocks_->blocks.push_back(block);
    }
  });
  return blocks_->blocks;
}

VoxelBox CellCover::closely() const {
  VoxelBox box;
  for (const Block& block : blocks()) box = united(box, block.covered);
  return box;
}

VoxelBox CellCover::voxels_among(const VoxelBox& voxels) const {
  const VoxelBox roughly = intersection(covered_, voxels);
  if (roughly.empty() || bounds_say_enough_) return roughly;
  VoxelBox among;
  for (const Block& block : blocks()) {
    among = united(among, intersection(block.covered, voxels));
  }
  return among;
}

VoxelBox CellCover::cells_over(const VoxelBox& voxels) const {
  if (intersection(covered_, voxels).empty()) return {};
  const VoxelBox cells = cells_by_bounds(reach_, glm::dvec3(voxels.lo), glm::dvec3(voxels.hi - 1));
  if (cells.empty() || bounds_say_enough_) return cells;
  VoxelBox of_blocks;
  for (const Block& block : blocks()) {
    if (!intersection(block.covered, voxels).empty()) of_blocks = united(of_blocks, block.cells);
  }
  return intersection(cells, of_blocks);
}

VoxelBox CellCover::cells_over(glm::dvec3 point) const {
  const VoxelBox around{VoxelIndex(glm::floor(point)), VoxelIndex(glm::floor(point)) + 2};
  if (intersection(covered_, around).empty()) return {};
  return cells_by_bounds(reach_, point, point);
}

}  // namespace maille
