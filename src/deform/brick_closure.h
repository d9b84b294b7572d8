// The max-plus closure of the labels inside one brick: raises every label to what its neighbours in
// the brick push it to, until nothing rises. Exact whatever the order of work, because the fixed
// point is unique and sums of integers are; so the widest vectors the machine has may do it.
#pragma once

#include <array>
#include <cstdint>

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
template <class L>
void close_brick(L* labels, Size3 extent, BrickSlack<L>& slack, DirtyRows& dirty,
                 DirtyRows& reached, int version = -1);

// What lower_labels() leaves above 0.
template <class L>
struct MovedLabels {
  bool any = false;
  L lowest = 0;  // over the elements in the volume
  L highest = 0;
  VoxelBox box{VoxelIndex(kBrickEdge), VoxelIndex(0)};  // of labels above 0, in the brick
  std::int64_t newly_moved = 0;  // labels above 0 where moved_rows had no bit yet
};

// Takes `overshoot` off every label, down to 0 at least. moved_rows: 32^2 words, a bit an element,
// set for each label that is above 0 then; or null.
template <class L>
MovedLabels<L> lower_labels(L* labels, Size3 extent, const DirtyRows& reached, L overshoot,
                            std::uint32_t* moved_rows, int version = -1);

int closure_versions();  // how many there are

}  // namespace maille
