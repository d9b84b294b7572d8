#include "resample/cut_cell.h"

namespace maille {

CutCell::CutCell(const Cuts& cuts, VoxelIndex base)
    : base_(base), size_(cuts.grid().volume_size()) {
  for (unsigned corner = 0; corner < 8; ++corner) {
    carved_ |= static_cast<unsigned>(cuts.carved(element(corner))) << corner;
  }
  for (unsigned axis = 0; axis < 3; ++axis) {
    const unsigned upper = 1u << axis;
    for (unsigned corner = 0; corner < 8; ++corner) {
      if (corner & upper) continue;
      const VoxelIndex from = element(corner);
      // What stands in for an element beyond the border is the element itself.
      const bool same = from == element(corner | upper);
      const bool ends = ((carved_ >> corner | carved_ >> (corner | upper)) & 1) == 0;
      const bool there = ends && (same || !cuts.removed(from, static_cast<int>(axis)));
      linked_[axis] |= static_cast<unsigned>(there) << corner;
    }
  }
}

VoxelIndex CutCell::element(unsigned corner) const {
  const VoxelIndex at = base_ + VoxelIndex(corner & 1, corner >> 1 & 1, corner >> 2);
  return glm::clamp(at, VoxelIndex(0), size_ - 1);
}

unsigned CutCell::joined(unsigned corner, unsigned axes) const {
  // Bits of the corners whose number has no bit outside of `axes`, moved to where `corner` is.
  constexpr std::array<unsigned, 8> kSpanned = {0x01, 0x03, 0x05, 0x0f, 0x11, 0x33, 0x55, 0xff};
  const unsigned box = kSpanned[axes] << (corner & ~axes);
  unsigned reached = 1u << corner;
  for (unsigned before = 0; before != reached;) {
    before = reached;
    for (unsigned axis = 0; axis < 3; ++axis) {
      const unsigned step = 1u << axis;
      const unsigned linked = linked_[axis];
      reached |= ((reached & linked) << step | (reached >> step & linked)) & box;
    }
  }
  return reached;
}

}  // namespace maille
