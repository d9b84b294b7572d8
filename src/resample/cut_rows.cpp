#include "resample/cut_rows.h"

#include <algorithm>

namespace maille {
namespace {

template <int axis>
const CutBrick::Rows& links(const CutBrick& brick) {
  return brick.removed[axis];
}
const CutBrick::Rows& carved(const CutBrick& brick) { return brick.carved; }

}  // namespace

CutRows::CutRows(const Cuts& cuts, const VoxelBox& cells) : cuts_(cuts), cells_(cells) {
  const BrickGrid& grid = cuts.grid();
  const BrickIndex lo = BrickGrid::brick_of(glm::max(cells.lo, VoxelIndex(0)));
  const BrickIndex hi = BrickGrid::brick_of(glm::min(cells.hi, grid.volume_size() - 1));
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x) any_ = any_ || cuts.brick(grid.linear({x, y, z}));
    }
  }
}

std::uint64_t CutRows::elements(const CutBrick::Rows& (*rows)(const CutBrick&), int y,
                                int z) const {
  const BrickGrid& grid = cuts_.grid();
  const int last = std::min(cells_.hi.x, grid.volume_size().x - 1);
  const auto row = static_cast<std::size_t>((z & 31) * kBrickEdge + (y & 31));
  std::uint64_t bits = 0;
  for (int x = std::max(cells_.lo.x, 0), end = 0; x <= last; x = end) {
    end = std::min((x | 31), last) + 1;
    const CutBrick* brick = cuts_.brick(grid.linear(BrickGrid::brick_of({x, y, z})));
    if (!brick) continue;
    const std::uint64_t stretch = rows(*brick)[row] >> (x & 31);
    bits |= (stretch & ((std::uint64_t{1} << (end - x)) - 1)) << (x - cells_.lo.x);
  }
  return bits;
}

// Gives corners past the border what their element has.
std::uint64_t CutRows::with_border(std::uint64_t elements) const {
  const int size = cuts_.grid().volume_size().x;
  if (cells_.hi.x == size) {
    const int last = size - 1 - cells_.lo.x;
    elements |= (elements >> last & 1) << (last + 1);
  }
  return cells_.lo.x < 0 ? elements | (elements >> 1 & 1) : elements;
}

std::uint64_t CutRows::cells(int y, int z) const {
  if (!any_) return 0;
  const Size3 size = cuts_.grid().volume_size();
  std::uint64_t along_x = 0;
  std::uint64_t others = 0;
  for (int k = 0; k < 4; ++k) {
    const bool upper_y = (k & 1) != 0;
    const bool upper_z = (k & 2) != 0;
    const int at_y = std::clamp(y + upper_y, 0, size.y - 1);
    const int at_z = std::clamp(z + upper_z, 0, size.z - 1);
    along_x |= elements(links<0>, at_y, at_z);
    others |= elements(carved, at_y, at_z);
    if (!upper_y && y >= 0 && y + 1 < size.y) others |= elements(links<1>, at_y, at_z);
    if (!upper_z && z >= 0 && z + 1 < size.z) others |= elements(links<2>, at_y, at_z);
  }
  others = with_border(others);
  const int last = size.x - 1 - cells_.lo.x;  // has no next along x
  if (last < 64) along_x &= ~(std::uint64_t{1} << last);
  return (along_x | others | others >> 1) & ((std::uint64_t{1} << cells_.size().x) - 1);
}

}  // namespace maille
