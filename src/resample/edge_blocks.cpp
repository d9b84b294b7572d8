#include "resample/edge_blocks.h"

#include "core/several_widths.h"

namespace maille {
namespace {

constexpr int kEdge = EdgeBlocks::kEdge;

// Of a whole block: the edges from each of its elements on. steps: in elements.
MAILLE_FOR_SEVERAL_WIDTHS
void take_whole(const Float4* first, std::ptrdiff_t width, std::ptrdiff_t plane,
                EdgeBounds& bounds) {
  static_assert(kEdge == 4);
  using Four = float __attribute__((vector_size(64)));
  const std::ptrdiff_t steps[3] = {1, width, plane};
  Four lowest[3], highest[3];
  for (int axis = 0; axis < 3; ++axis) {
    lowest[axis] = Four{} + std::numeric_limits<float>::max();
    highest[axis] = -lowest[axis];
  }
  for (int z = 0; z < kEdge; ++z) {
    for (int y = 0; y < kEdge; ++y) {
      const Float4* const row = first + z * plane + y * width;
      Four from;
      __builtin_memcpy(&from, row, sizeof from);
      for (int axis = 0; axis < 3; ++axis) {
        Four to;
        __builtin_memcpy(&to, row + steps[axis], sizeof to);
        const Four edge = to - from;
        lowest[axis] = edge < lowest[axis] ? edge : lowest[axis];
        highest[axis] = edge > highest[axis] ? edge : highest[axis];
      }
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Float4 parts[2][4];
    __builtin_memcpy(parts[0], &lowest[axis], sizeof lowest[axis]);
    __builtin_memcpy(parts[1], &highest[axis], sizeof highest[axis]);
    bounds.lowest[axis] = least(least(parts[0][0], parts[0][1]), least(parts[0][2], parts[0][3]));
    bounds.highest[axis] =
        greatest(greatest(parts[1][0], parts[1][1]), greatest(parts[1][2], parts[1][3]));
  }
}

}  // namespace

EdgeBlocks::EdgeBlocks(const DisplacementTile& tile)
    : tile_size_(tile.elements().size()), size_((tile_size_ + kEdge - 1) / kEdge) {
  const Size3 last = tile_size_ - 1;
  const std::ptrdiff_t width = tile_size_.x;
  const std::ptrdiff_t plane = width * tile_size_.y;
  blocks_.assign(static_cast<std::size_t>(voxel_count(size_)), EdgeBounds());
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    EdgeBounds& of_block = blocks_[i];
    const VoxelIndex lo = voxel_index(static_cast<std::int64_t>(i), size_) * kEdge;
    const VoxelIndex hi = glm::min(lo + kEdge, tile_size_);
    if (glm::all(glm::lessThanEqual(lo + kEdge, last))) {
      take_whole(tile.row(lo.y, lo.z) + lo.x, width, plane, of_block);
      continue;
    }
    for (int z = lo.z; z < hi.z; ++z) {
      for (int y = lo.y; y < hi.y; ++y) {
        const Float4* const row = tile.row(y, z);
        for (int x = lo.x; x < hi.x; ++x) {
          if (x < last.x) of_block.take(0, row[x + 1] - row[x]);
          if (y < last.y) of_block.take(1, row[x + width] - row[x]);
          if (z < last.z) of_block.take(2, row[x + plane] - row[x]);
        }
      }
    }
  }
}

EdgeBlocks::Surroundings EdgeBlocks::around(VoxelIndex block) const {
  const VoxelIndex first = glm::max(block - 1, VoxelIndex(0));
  const VoxelIndex end = glm::min(block + 2, size_);
  // The edges from the last elements of all lead on to blocks beyond.
  Surroundings around{first * kEdge, glm::min(end * kEdge, tile_size_) - 1, {}};
  for (int axis = 0; axis < 3; ++axis) {
    if (tile_size_[axis] == 1) around.edges.take(static_cast<std::size_t>(axis), Float4{});
  }
  for (int z = first.z; z < end.z; ++z) {
    for (int y = first.y; y < end.y; ++y) {
      for (int x = first.x; x < end.x; ++x) {
        around.edges.take(blocks_[static_cast<std::size_t>(linear_index({x, y, z}, size_))]);
      }
    }
  }
  return around;
}

}  // namespace maille
