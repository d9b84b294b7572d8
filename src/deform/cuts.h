// What has been taken out of the lattice: links that a cut removed and elements that were carved.
//
// A link belongs to its lower element and runs to the next one along an axis. All links of a carved
// element are removed. A removed link holds nothing: no ChainMail limit, no spring, no resampled
// cell across it. There is no state at all before the first cut.
#pragma once

#include <array>
#include <cstdint>

#include "deform/lattice_brick.h"
#include "volume/brick_table.h"

namespace maille {

struct CutBrick {
  // A bit an element, bit x of row (z * 32 + y), brick-local.
  using Rows = std::array<std::uint32_t, kBrickEdge * kBrickEdge>;
  std::array<Rows, 3> removed{};  // [axis]: the link to the next element along it
  Rows carved{};
};

class Cuts : public BrickTable<CutBrick> {
 public:
  using BrickTable::BrickTable;

  bool carved(VoxelIndex voxel) const {
    return bit(voxel, [](auto& b) { return &b.carved; });
  }
  bool removed(VoxelIndex lower, int axis) const {
    return bit(lower, [&](auto& b) { return &b.removed[static_cast<std::size_t>(axis)]; });
  }

 private:
  template <class F>
  bool bit(VoxelIndex voxel, F&& rows) const {
    const CutBrick* b = brick(grid().linear(BrickGrid::brick_of(voxel)));
    if (!b) return false;
    const auto e = static_cast<std::size_t>(element_in_brick(voxel));
    return ((*rows(*b))[e / kBrickEdge] >> (e % kBrickEdge)) & 1;
  }
};

}  // namespace maille
