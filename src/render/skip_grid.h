// How far a ray may go without a look: for each block of voxels how many blocks away the nearest
// one is in which something shows.
//
// In the Chebyshev metric, so that a block whose nearest is d away stands in the middle of a cube
// of 2d - 1 blocks of nothing. Kept up to date around what changed only. A pass on the device is
// the road not taken: on the CPU a whole grid of 64 x 64 x 42 takes less than the bricks that
// change it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volume/brick.h"

namespace maille {

class SkipGrid {
 public:
  // Of nothing further away is told how far.
  static constexpr int kFurthest_blocks = 16;

  SkipGrid() = default;
  // Nothing shows anywhere.
  explicit SkipGrid(Size3 blocks);

  Size3 blocks() const { return blocks_; }
  bool shows(glm::ivec3 block) const {
    return shows_[static_cast<std::size_t>(linear_index(block, blocks_))] != 0;
  }
  void set(glm::ivec3 block, bool shows);

  // Brings the distances up to date with what was set. True where that changed anything.
  bool update();
  // One byte a block (x fastest), padded to whole 32-bit words: 0 where something shows.
  std::span<const std::uint8_t> distances() const { return distances_; }

 private:
  Size3 blocks_{0};
  std::vector<std::uint8_t> shows_;
  std::vector<std::uint8_t> distances_;
  VoxelBox changed_;  // of blocks
};

}  // namespace maille
