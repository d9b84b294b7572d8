// The lattice's corners as it lies now, read in order: what every walk over deformed cells stands
// on.
#pragma once

#include <algorithm>
#include <vector>

#include "deform/lattice.h"
#include "resample/deformed_cell.h"

namespace maille {

// One line of corners along x, with the bounds of their positions (fourth lane: above 0 where any
// has moved) and which of them have moved.
struct CornerRow {
  const Float4* corners = nullptr;
  Float4 lowest{};
  Float4 highest{};
  int first_moved = 0;  // counted from the first cell; first > last: none
  int last_moved = -1;
};

// Two planes of corner positions, filled as a walk through a box of cells needs them.
class CornerPlanes {
 public:
  // cells: bases, within -1 .. size-1 of the volume. Positions are relative to origin, in voxels.
  CornerPlanes(const Lattice& lattice, const VoxelBox& cells, glm::ivec3 origin);

  // Makes the planes z and z+1 ready; z must rise by one from call to call.
  void advance_to(int z) { fill(z + 1); }

  // Row y of plane z or z+1, as made ready.
  const CornerRow& row(int y, int z) const {
    return planes_[static_cast<std::size_t>(z & 1)].rows[static_cast<std::size_t>(y - cells_.lo.y)];
  }

 private:
  struct Plane {
    std::vector<Float4> corners;
    std::vector<CornerRow> rows;
  };

  void fill(int z);
  CornerRow fill_row(Float4* out, int y, int z) const;

  const Lattice& lattice_;
  VoxelBox cells_;
  glm::ivec3 origin_;
  int width_;
  Plane planes_[2];
};

// Bounds of four rows together: those around one row of cells, or around one cell.
inline Float4 least_of(Float4 a, Float4 b, Float4 c, Float4 d) {
  return least(least(a, b), least(c, d));
}
inline Float4 greatest_of(Float4 a, Float4 b, Float4 c, Float4 d) {
  return greatest(greatest(a, b), greatest(c, d));
}

// Calls f(cell, base, lowest corner, highest corner) for the cells of a box that have a moved
// corner and whose row can touch the box from `low` to `high`. Positions are relative to origin.
template <class F>
void for_each_moved_cell(const Lattice& lattice, const VoxelBox& cells, glm::ivec3 origin,
                         glm::vec3 low, glm::vec3 high, F&& f) {
  if (cells.empty()) return;
  const auto misses = [&](Float4 lowest, Float4 highest) {
    return lowest[0] > high.x || lowest[1] > high.y || lowest[2] > high.z || highest[0] < low.x ||
           highest[1] < low.y || highest[2] < low.z;
  };
  CornerPlanes planes(lattice, cells, origin);
  for (int z = cells.lo.z; z < cells.hi.z; ++z) {
    planes.advance_to(z);
    for (int y = cells.lo.y; y < cells.hi.y; ++y) {
      const CornerRow& a = planes.row(y, z);
      const CornerRow& b = planes.row(y + 1, z);
      const CornerRow& c = planes.row(y, z + 1);
      const CornerRow& d = planes.row(y + 1, z + 1);
      const int first =
          std::max(0, std::min({a.first_moved, b.first_moved, c.first_moved, d.first_moved}) - 1);
      const int last = std::min(cells.size().x - 1,
                                std::max({a.last_moved, b.last_moved, c.last_moved, d.last_moved}));
      if (first > last) continue;
      if (misses(least_of(a.lowest, b.lowest, c.lowest, d.lowest),
                 greatest_of(a.highest, b.highest, c.highest, d.highest))) {
        continue;
      }
      const auto lowest_at = [&](int x) {
        return least_of(a.corners[x], b.corners[x], c.corners[x], d.corners[x]);
      };
      const auto highest_at = [&](int x) {
        return greatest_of(a.corners[x], b.corners[x], c.corners[x], d.corners[x]);
      };
      Float4 lowest_here = lowest_at(first);
      Float4 highest_here = highest_at(first);
      for (int x = first; x <= last; ++x) {
        const Float4 lowest_next = lowest_at(x + 1);
        const Float4 highest_next = highest_at(x + 1);
        const Float4 lowest = least(lowest_here, lowest_next);
        const Float4 highest = greatest(highest_here, highest_next);
        lowest_here = lowest_next;
        highest_here = highest_next;
        if (highest[3] == 0.0f || misses(lowest, highest)) continue;
        const DeformedCell cell{{a.corners[x], a.corners[x + 1], b.corners[x], b.corners[x + 1],
                                 c.corners[x], c.corners[x + 1], d.corners[x], d.corners[x + 1]}};
        f(cell, VoxelIndex(cells.lo.x + x, y, z), lowest, highest);
      }
    }
  }
}

}  // namespace maille
