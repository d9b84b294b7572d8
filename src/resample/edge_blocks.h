// Bounds of a tile's edges, by blocks of cells and what lies around each: so near to a point cells
// differ much less than over all of the tile.
#pragma once

#include <vector>

#include "resample/displacement_tile.h"

namespace maille {

class EdgeBlocks {
 public:
  static constexpr int kLog2Edge = 2;
  static constexpr int kEdge = 1 << kLog2Edge;  // of a block, in elements

  explicit EdgeBlocks(const DisplacementTile& tile);

  // Blocks along each axis.
  const Size3& size() const { return size_; }
  // What the bounds of a block are of: the elements from `lo` to `hi`, both among them.
  struct Surroundings {
    VoxelIndex lo, hi;
    EdgeBounds edges;
  };
  Surroundings around(VoxelIndex block) const;

 private:
  Size3 tile_size_{0};
  Size3 size_{0};
  std::vector<EdgeBounds> blocks_;
};

}  // namespace maille
