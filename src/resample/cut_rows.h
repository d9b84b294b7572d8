// Which cells of a box have a removed link among their edges, or a carved corner? Row by row.
#pragma once

#include <cstdint>

#include "deform/cuts.h"

namespace maille {

class CutRows {
 public:
  // cells: bases, within -1 .. size-1 of the volume, at most 63 along x. The cuts must outlive it.
  CutRows(const Cuts& cuts, const VoxelBox& cells);

  // Whether anything has been cut or carved in the bricks of the cells' corners.
  bool any() const { return any_; }

  // Bit x: the cell x cells from the first in row y of plane z is cut.
  std::uint64_t cells(int y, int z) const;

 private:
  // Bit x: whether the element of corner x has a bit set; corners past the border have none.
  std::uint64_t elements(const CutBrick::Rows& (*rows)(const CutBrick&), int y, int z) const;
  std::uint64_t with_border(std::uint64_t elements) const;

  const Cuts& cuts_;
  VoxelBox cells_;
  bool any_ = false;
};

}  // namespace maille
