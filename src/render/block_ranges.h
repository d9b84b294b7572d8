// What the voxels of every 8^3 block are, so that a block that shows nothing is skipped exactly.
//
// A sample between voxels is interpolated from the 8 around it, so a block answers for the samples
// with floor(position) in it: 9^3 voxels, one layer beyond its own. Inside a brick these 9^3 are
// looked at; where the layer lies in the next brick, that brick's whole block is counted in, which
// is never too little. Values are in stored units, as in the file.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "volume/brick.h"
#include "volume/volume.h"

namespace maille {

inline constexpr int kBlockEdge = 8;
inline constexpr int kBrickBlocks = kBrickEdge / kBlockEdge;

struct ValueRange {
  float lowest = std::numeric_limits<float>::infinity();
  float highest = -std::numeric_limits<float>::infinity();
  bool empty() const { return lowest > highest; }
};

// Of one brick's blocks, over their 9^3 voxels cut off at the brick; x fastest, 4^3.
using BrickRanges = std::array<ValueRange, kBrickBlocks * kBrickBlocks * kBrickBlocks>;

// voxels: tightly packed over a box of that size, in texture encoding. Samples of a float volume
// that are not finite are overwritten with stand_in first: one NaN would spread over 8 cells.
BrickRanges ranges_of_brick(Size3 size, std::span<std::byte> voxels, VoxelType type,
                            float stand_in);

class BlockRanges {
 public:
  BlockRanges() = default;
  explicit BlockRanges(Size3 volume_size);

  Size3 blocks() const { return blocks_; }
  void set(BrickIndex brick, const BrickRanges& ranges);
  // Of the voxels that a block answers for; empty while its brick was never set.
  ValueRange range(glm::ivec3 block) const;

 private:
  Size3 blocks_{0};
  std::vector<ValueRange> own_;
};

}  // namespace maille
