#include "render/block_ranges.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace maille {
namespace {

// Rows first: the 81 rows of a layer of blocks are folded into one row of minima and one of maxima,
// which the compiler does in whole registers; only that row is looked at sample by sample.
template <class T>
BrickRanges ranges_of(Size3 size, std::span<const T> voxels, float offset) {
  BrickRanges ranges;
  std::array<T, kBrickEdge> low{};
  std::array<T, kBrickEdge> high{};
  const auto width = static_cast<std::size_t>(size.x);
  for (int bz = 0; bz * kBlockEdge < size.z; ++bz) {
    for (int by = 0; by * kBlockEdge < size.y; ++by) {
      const int z_end = std::min(bz * kBlockEdge + kBlockEdge + 1, size.z);
      const int y_end = std::min(by * kBlockEdge + kBlockEdge + 1, size.y);
      low.fill(std::numeric_limits<T>::max());
      high.fill(std::numeric_limits<T>::lowest());
      for (int z = bz * kBlockEdge; z < z_end; ++z) {
        for (int y = by * kBlockEdge; y < y_end; ++y) {
          const T* row = voxels.data() + linear_index({0, y, z}, size);
          for (std::size_t x = 0; x < width; ++x) {
            low[x] = std::min(low[x], row[x]);
            high[x] = std::max(high[x], row[x]);
          }
        }
      }
      for (int bx = 0; bx * kBlockEdge < size.x; ++bx) {
        const int x_end = std::min(bx * kBlockEdge + kBlockEdge + 1, size.x);
        const auto* first = low.data() + bx * kBlockEdge;
        const auto* top = high.data() + bx * kBlockEdge;
        const auto count = x_end - bx * kBlockEdge;
        ranges[static_cast<std::size_t>((bz * kBrickBlocks + by) * kBrickBlocks + bx)] = {
            static_cast<float>(*std::min_element(first, first + count)) + offset,
            static_cast<float>(*std::max_element(top, top + count)) + offset};
      }
    }
  }
  return ranges;
}

template <class T>
std::span<T> as_samples(std::span<std::byte> voxels) {
  return {reinterpret_cast<T*>(voxels.data()), voxels.size() / sizeof(T)};
}

}  // namespace

BrickRanges ranges_of_brick(Size3 size, std::span<std::byte> voxels, VoxelType type,
                            float stand_in) {
  switch (type) {
    case VoxelType::uint8:
      return ranges_of<std::uint8_t>(size, as_samples<std::uint8_t>(voxels), 0.0f);
    case VoxelType::int8:
      return ranges_of<std::uint8_t>(size, as_samples<std::uint8_t>(voxels), -128.0f);
    case VoxelType::uint16:
      return ranges_of<std::uint16_t>(size, as_samples<std::uint16_t>(voxels), 0.0f);
    case VoxelType::int16:
      return ranges_of<std::uint16_t>(size, as_samples<std::uint16_t>(voxels), -32768.0f);
    case VoxelType::float32: break;
  }
  const auto samples = as_samples<float>(voxels);
  for (float& sample : samples) {
    if (!std::isfinite(sample)) sample = stand_in;
  }
  return ranges_of<float>(size, samples, 0.0f);
}

BlockRanges::BlockRanges(Size3 volume_size)
    : blocks_((volume_size + (kBlockEdge - 1)) / kBlockEdge),
      own_(static_cast<std::size_t>(voxel_count(blocks_))) {}

void BlockRanges::set(BrickIndex brick, const BrickRanges& ranges) {
  const glm::ivec3 lo = brick * kBrickBlocks;
  const glm::ivec3 hi = glm::min(lo + kBrickBlocks, blocks_);
  for (int z = lo.z; z < hi.z; ++z) {
    for (int y = lo.y; y < hi.y; ++y) {
      for (int x = lo.x; x < hi.x; ++x) {
        own_[static_cast<std::size_t>(linear_index({x, y, z}, blocks_))] =
            ranges[static_cast<std::size_t>(
                ((z - lo.z) * kBrickBlocks + (y - lo.y)) * kBrickBlocks + (x - lo.x))];
      }
    }
  }
}

ValueRange BlockRanges::range(glm::ivec3 block) const {
  ValueRange range = own_[static_cast<std::size_t>(linear_index(block, blocks_))];
  if (range.empty()) return range;
  // Along which axes does the ninth layer lie in the next brick?
  const glm::ivec3 reach =
      glm::ivec3(glm::equal(block % kBrickBlocks, glm::ivec3(kBrickBlocks - 1)));
  if (reach == glm::ivec3(0)) return range;
  const glm::ivec3 last = glm::min(block + 1, blocks_ - 1);
  for (int z = block.z; z <= last.z; ++z) {
    for (int y = block.y; y <= last.y; ++y) {
      for (int x = block.x; x <= last.x; ++x) {
        const glm::ivec3 next{x, y, z};
        // Within the brick the ninth layer is counted in already, and no more than it.
        const glm::ivec3 step = next - block;
        if (step * reach == glm::ivec3(0)) continue;
        const ValueRange& other = own_[static_cast<std::size_t>(linear_index(next, blocks_))];
        range.lowest = std::min(range.lowest, other.lowest);
        range.highest = std::max(range.highest, other.highest);
      }
    }
  }
  return range;
}

}  // namespace maille
