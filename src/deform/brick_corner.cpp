#include "deform/brick_corner.h"

#include <algorithm>

namespace maille {

void BrickCorner::read(const Lattice& lattice, std::int64_t brick) {
  const BrickGrid& grid = lattice.grid();
  const BrickIndex first = grid.brick(brick);
  box_ = grid.box(first);
  with_next_ = {box_.lo, glm::min(box_.hi + 1, grid.volume_size())};
  at_rest_ = true;
  for (int i = 0; i < 8; ++i) {
    const BrickIndex there = first + BrickIndex(i & 1, (i >> 1) & 1, i >> 2);
    if (grid.contains(there) && lattice.brick(grid.linear(there))) at_rest_ = false;
  }
  if (!at_rest_) read_elements(lattice);
}

void BrickCorner::read_elements(const Lattice& lattice) {
  for (auto& u : u_) u.resize(static_cast<std::size_t>(voxel_count(with_next_.size())));
  std::size_t at = 0;
  for (int z = with_next_.lo.z; z < with_next_.hi.z; ++z) {
    for (int y = with_next_.lo.y; y < with_next_.hi.y; ++y) {
      for (int x = with_next_.lo.x; x < with_next_.hi.x;) {
        const BrickIndex brick = BrickGrid::brick_of({x, y, z});
        const LatticeBrick* from = lattice.brick(lattice.grid().linear(brick));
        const int count = std::min(with_next_.hi.x, (x | 31) + 1) - x;
        for (int c = 0; c < 3; ++c) {
          std::int32_t* const u = &u_[static_cast<std::size_t>(c)][at];
          if (from) {
            from->read_row(c, element_in_brick({x, y, z}), count, u);
          } else {
            std::fill_n(u, count, 0);
          }
        }
        at += static_cast<std::size_t>(count);
        x += count;
      }
    }
  }
}

}  // namespace maille
