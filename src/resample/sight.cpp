#include "resample/sight.h"

#include <algorithm>

#include "resample/cut_rows.h"

namespace maille {
namespace {

bool any_cut_among(const Cuts& cuts, const VoxelBox& cells) {
  if (cells.empty()) return false;
  const CutRows rows(cuts, cells);
  if (!rows.any()) return false;
  for (int z = cells.lo.z; z < cells.hi.z; ++z) {
    for (int y = cells.lo.y; y < cells.hi.y; ++y) {
      if (rows.cells(y, z) != 0) return true;
    }
  }
  return false;
}

// What is left of a cut cell reaches half a voxel beyond its corners.
VoxelBox with_octants(const VoxelBox& voxels) { return {voxels.lo - 1, voxels.hi + 1}; }

}  // namespace

Sight::Sight(const DeformedVolume& volume, const VoxelBox& voxels) : volume_(volume) {
  for (const DeformedVolume::Entry& entry : volume.entries) {
    const VoxelBox in_sight{voxels.lo - kAround_voxels, voxels.hi + kAround_voxels};
    if (!intersection(entry.cover.roughly(), in_sight).empty()) entries_.push_back(&entry);
  }
}

bool Sight::cut(const VoxelBox& part) const {
  if (!volume_.any_cut) return false;
  const VoxelBox here =
      intersection({part.lo - 1, part.hi}, {VoxelIndex(-1), VoxelIndex(volume_.size())});
  if (any_cut_among(volume_.cuts, here)) return true;
  return std::any_of(entries_.begin(), entries_.end(), [&](const DeformedVolume::Entry* entry) {
    return entry->cut && any_cut_among(volume_.cuts, entry->cover.cells_over(with_octants(part)));
  });
}

VoxelBox Sight::coverable(const VoxelBox& part) const {
  VoxelBox box;
  for (const DeformedVolume::Entry* entry : entries_) {
    box = united(box, entry->cover.voxels_among(part));
  }
  return box;
}

bool Sight::rests_somewhere(const VoxelBox& elements) const {
  const BrickIndex lo = BrickGrid::brick_of(elements.lo);
  const BrickIndex hi = BrickGrid::brick_of(elements.hi - 1);
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x) {
        const VoxelIndex first = BrickIndex(x, y, z) * kBrickEdge;
        const VoxelBox of_brick = intersection(elements, {first, first + kBrickEdge});
        const LatticeBrick* const brick = volume_.moved_at(first);
        if (!brick || intersection(of_brick, brick->moved()) != of_brick) return true;
      }
    }
  }
  return false;
}

VoxelBox Sight::elements_over(const VoxelBox& part) const {
  const VoxelBox in_volume{VoxelIndex(0), volume_.size()};
  // What is at rest covers its own voxels.
  const VoxelBox here = intersection({part.lo - 1, part.hi + 1}, in_volume);
  VoxelBox elements = !here.empty() && rests_somewhere(here) ? here : VoxelBox();
  for_each_cells_over(part, [&](const VoxelBox& cells, const DeformedVolume::Entry&) {
    elements = united(elements, {cells.lo, cells.hi + 1});
  });
  return intersection(elements, in_volume);
}

std::optional<glm::ivec3> Sight::whole_shift(const VoxelBox& part) const {
  const BrickGrid& grid = volume_.lattice.grid();
  const LatticeBrick* const here = volume_.moved_at(part.lo);
  if (!here) return std::nullopt;
  const glm::ivec3 u = here->lowest();
  if (u != here->highest() || u % kUnitsPerVoxel != glm::ivec3(0) || cut(part)) {
    return std::nullopt;
  }
  const VoxelBox elements = elements_over(part);
  if (elements.empty()) return std::nullopt;
  const BrickIndex lo = BrickGrid::brick_of(elements.lo);
  const BrickIndex hi = BrickGrid::brick_of(elements.hi - 1);
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x) {
        const LatticeBrick* const other = volume_.lattice.brick(grid.linear({x, y, z}));
        if (!other || other->lowest() != u || other->highest() != u) return std::nullopt;
      }
    }
  }
  // What would come from elsewhere does not: nothing there can reach so far.
  const glm::ivec3 shift = u / kUnitsPerVoxel;
  const VoxelBox from =
      intersection({part.lo - shift, part.hi - shift}, {VoxelIndex(0), volume_.size()});
  if (!from.empty() && intersection(from, elements) != from) return std::nullopt;
  return shift;
}

}  // namespace maille
