// A cell with a removed link among its edges, or a carved corner: who is still joined to whom.
//
// Material is a complex of octants: each element owns the eighth of each cell around it that lies
// nearest to it at rest. An octant's own corners are the element and the middles of the edges,
// faces and the cell that it touches. Where such a middle lies now, and what value it has, is the
// mean over those of its edge's (face's, cell's) corners that are joined to the element by links of
// that edge (face, cell); they pull it along rigidly. Hence
//
// - a cell with all its links is its trilinear self: a trilinear map is the one its values at the
//   eight corners of an octant make of that octant;
// - octants that share a face share its corners, within a cell where the link between their
//   elements is there, and always between two cells: there is no crack but where a link is gone;
// - across a removed link nothing is mixed, and material ends half a voxel beyond its last element,
//   as it does at the volume's border; a cut that ends inside the volume tapers out.
//
// Joining whole components of a cell to one hexahedron each, its missing corners placed by the
// nearest, is the road not taken: neighbouring cells place them differently, and cracks follow
// every staircase of an oblique cut; and at a cut's rim, where all corners are joined around the
// end, it mixes across the removed links.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "deform/cuts.h"

namespace maille {

class CutCell {
 public:
  // base: within -1 .. size-1, as of every cell.
  CutCell(const Cuts& cuts, VoxelIndex base);

  // Corner (i,j,k) is number i + 2j + 4k; beyond the border the border's element stands in.
  VoxelIndex element(unsigned corner) const;
  bool carved(unsigned corner) const { return ((carved_ >> corner) & 1) != 0; }
  bool intact(unsigned corner, int axis) const {
    return ((linked_[static_cast<std::size_t>(axis)] >> (corner & ~(1u << axis))) & 1) != 0;
  }

  // The corners (a bit each) joined to one that is not carved, by links of the box between it and
  // its opposite along `axes` (a bit each): of an edge, a face or the cell.
  unsigned joined(unsigned corner, unsigned axes) const;

 private:
  VoxelIndex base_;
  Size3 size_;
  unsigned carved_ = 0;
  std::array<unsigned, 3> linked_{};  // [axis]: a bit for the lower corner of every intact edge
};

// Calls f(corner) for each of a set of corners.
template <class F>
void for_each_corner(unsigned corners, F&& f) {
  for (; corners != 0; corners &= corners - 1) f(static_cast<unsigned>(std::countr_zero(corners)));
}

}  // namespace maille
