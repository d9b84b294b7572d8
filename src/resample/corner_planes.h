// The lattice's corners as it lies now, read in order: what every walk over deformed cells stands
// on.
#pragma once

#include <algorithm>
#include <bit>
#include <optional>
#include <vector>

#include "deform/lattice.h"
#include "resample/cut_rows.h"
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

// Cells with all their links are one trilinear map each; the others need a closer look.
enum class CellKind { whole, cut };

// Rest coordinate of a corner: half a voxel beyond the border for the two that are no element.
inline float rest_coordinate(int corner, int size) {
  return corner < 0       ? -0.5f
         : corner >= size ? static_cast<float>(size) - 0.5f
                          : static_cast<float>(corner);
}

// Two planes of corner positions, filled as a walk through a box of cells needs them.
class CornerPlanes {
 public:
  // cells: bases, within -1 .. size-1 of the volume, those of a brick and a few around it. cuts may
  // be null. Positions are relative to origin, in voxels.
  CornerPlanes(const Lattice& lattice, const Cuts* cuts, const VoxelBox& cells, glm::ivec3 origin);

  // Makes the planes z and z+1 ready; z must rise by one from call to call.
  void advance_to(int z) { fill(z + 1); }

  // Row y of plane z or z+1, as made ready.
  const CornerRow& row(int y, int z) const {
    return planes_[static_cast<std::size_t>(z & 1)].rows[static_cast<std::size_t>(y - cells_.lo.y)];
  }

  bool any_cut() const { return cut_rows_.has_value(); }
  // Bit x: cell x of a row is cut.
  std::uint64_t cut_cells(int y, int z) const { return cut_rows_ ? cut_rows_->cells(y, z) : 0; }

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
  std::optional<CutRows> cut_rows_;  // only where something is cut
  Plane planes_[2];
};

// One line of cells along x, between the four lines of corners around it.
class CellRow {
 public:
  CellRow(const CornerPlanes& planes, int y, int z, int cells)
      : a_(planes.row(y, z)),
        b_(planes.row(y + 1, z)),
        c_(planes.row(y, z + 1)),
        d_(planes.row(y + 1, z + 1)),
        first_(std::max(
            0, std::min({a_.first_moved, b_.first_moved, c_.first_moved, d_.first_moved}) - 1)),
        last_(std::min(cells - 1,
                       std::max({a_.last_moved, b_.last_moved, c_.last_moved, d_.last_moved}))),
        cut_(at_rest() ? 0 : planes.cut_cells(y, z)) {}

  bool at_rest() const { return first_ > last_; }

  // Bounds of all its corners.
  Float4 lowest() const { return least(least(a_.lowest, b_.lowest), least(c_.lowest, d_.lowest)); }
  Float4 highest() const {
    return greatest(greatest(a_.highest, b_.highest), greatest(c_.highest, d_.highest));
  }

  // Calls f(x, lowest corner, highest corner) for a stretch of cells that holds all whole ones with
  // a moved corner (highest corner's fourth lane above 0), x counted from the first cell.
  // Neighbours share the bounds of the corners between them.
  template <class F>
  void for_each_whole(F&& f) const {
    if (at_rest()) return;
    Float4 lowest_here = lowest_at(first_);
    Float4 highest_here = highest_at(first_);
    for (int x = first_; x <= last_; ++x) {
      const Float4 lowest_next = lowest_at(x + 1);
      const Float4 highest_next = highest_at(x + 1);
      if (((cut_ >> x) & 1) == 0) {
        f(x, least(lowest_here, lowest_next), greatest(highest_here, highest_next));
      }
      lowest_here = lowest_next;
      highest_here = highest_next;
    }
  }

  // The same for the cut ones, and exactly those among them that have a moved corner.
  template <class F>
  void for_each_cut(F&& f) const {
    for (std::uint64_t left = cut_; left != 0; left &= left - 1) {
      const int x = std::countr_zero(left);
      const Float4 highest = greatest(highest_at(x), highest_at(x + 1));
      if (highest[3] > 0.0f) f(x, least(lowest_at(x), lowest_at(x + 1)), highest);
    }
  }

  DeformedCell cell(int x) const {
    return {{a_.corners[x], a_.corners[x + 1], b_.corners[x], b_.corners[x + 1], c_.corners[x],
             c_.corners[x + 1], d_.corners[x], d_.corners[x + 1]}};
  }

 private:
  Float4 lowest_at(int x) const {
    return least(least(a_.corners[x], b_.corners[x]), least(c_.corners[x], d_.corners[x]));
  }
  Float4 highest_at(int x) const {
    return greatest(greatest(a_.corners[x], b_.corners[x]), greatest(c_.corners[x], d_.corners[x]));
  }

  const CornerRow& a_;
  const CornerRow& b_;
  const CornerRow& c_;
  const CornerRow& d_;
  int first_;
  int last_;
  std::uint64_t cut_;
};

// Rising. A cell belongs to the brick of its base; its moved corners may lie in the next ones.
std::vector<std::int64_t> bricks_with_moved_cells(const Lattice& lattice);

// Calls f(cell, base, lowest corner, highest corner) for the cells of a kind in a box that have a
// moved corner and can touch the box from `low` to `high`: what is left of a cut cell reaches half
// a voxel beyond its corners. cuts may be null. Positions are relative to origin.
template <CellKind kind = CellKind::whole, class F>
void for_each_moved_cell(const Lattice& lattice, const Cuts* cuts, const VoxelBox& cells,
                         glm::ivec3 origin, glm::vec3 low, glm::vec3 high, F&& f) {
  if (cells.empty()) return;
  if constexpr (kind == CellKind::cut) {
    low -= 0.5f;
    high += 0.5f;
  }
  const auto misses = [&](Float4 lowest, Float4 highest) {
    return lowest[0] > high.x || lowest[1] > high.y || lowest[2] > high.z || highest[0] < low.x ||
           highest[1] < low.y || highest[2] < low.z;
  };
  CornerPlanes planes(lattice, cuts, cells, origin);
  if (kind == CellKind::cut && !planes.any_cut()) return;
  for (int z = cells.lo.z; z < cells.hi.z; ++z) {
    planes.advance_to(z);
    for (int y = cells.lo.y; y < cells.hi.y; ++y) {
      const CellRow row(planes, y, z, cells.size().x);
      if (row.at_rest() || misses(row.lowest(), row.highest())) continue;
      const auto visit = [&](int x, Float4 lowest, Float4 highest) {
        if (highest[3] == 0.0f || misses(lowest, highest)) return;
        const DeformedCell cell = row.cell(x);
        f(cell, VoxelIndex(cells.lo.x + x, y, z), lowest, highest);
      };
      if constexpr (kind == CellKind::cut) {
        row.for_each_cut(visit);
      } else {
        row.for_each_whole(visit);
      }
    }
  }
}

}  // namespace maille
