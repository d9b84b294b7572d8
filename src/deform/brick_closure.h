// The max-plus closure of the labels inside one brick: raises every label to what its neighbours in
// the brick push it to, until nothing rises. Exact whatever the order of work, because the fixed
// point is unique and sums of integers are; so the widest vectors the machine has may do it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "deform/brick_slack.h"

namespace maille {

// Rows with something new to pass on: bit y of word z.
struct DirtyRows {
  std::array<std::uint32_t, kBrickEdge> rows{};
  void mark(int y, int z) { rows[static_cast<std::size_t>(z)] |= std::uint32_t{1} << y; }
  bool any() const {
    std::uint32_t all = 0;
    for (const std::uint32_t r : rows) all |= r;
    return all != 0;
  }
};

// labels: 32^3, 0 beyond the border. dirty: the rows that have risen since the labels were last
// closed; none afterwards. reached: every row that has ever risen, kept up to date. slack: of the
// brick; its rows are prepared as they are reached. version: which of the machine's versions of the
// code, 0 the plainest; -1 takes the best. Tests prove them equal.
void close_brick(std::uint16_t* labels, Size3 extent, BrickSlack<std::uint16_t>& slack,
                 DirtyRows& dirty, DirtyRows& reached, int version = -1);
void close_brick(std::uint32_t* labels, Size3 extent, BrickSlack<std::uint32_t>& slack,
                 DirtyRows& dirty, DirtyRows& reached, int version = -1);
int close_brick_versions();  // from 0 on

}  // namespace maille
