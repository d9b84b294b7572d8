#include "resample/deformed_volume.h"

#include <algorithm>
#include <cmath>

#include "resample/cut_rows.h"

namespace maille {

DeformedVolume::DeformedVolume(Lattice deformed, Cuts with_cuts, glm::dvec3 spacing)
    : lattice(std::move(deformed)), cuts(std::move(with_cuts)), spacing_mm(spacing) {
  any_cut = !cuts.empty();
  lattice.for_each_brick([&](std::int64_t b, const LatticeBrick&) {
    const Reach reach = reach_of(lattice, b);
    // The moved box is tight: where it touches the border, an element there has moved.
    const bool at_border = glm::any(glm::lessThan(reach.cells.lo, VoxelIndex(0))) ||
                           glm::any(glm::equal(reach.cells.hi, VoxelIndex(size())));
    const bool cut = any_cut && CutRows(cuts, reach.cells).any();
    entries.push_back({reach, reach.covered(size()), at_border, cut});
    border_moved = border_moved || at_border;
  });
}

bool DeformedVolume::cut_in_sight(const VoxelBox& voxels) const {
  return std::any_of(entries.begin(), entries.end(), [&](const Entry& entry) {
    return entry.cut && !intersection(entry.covered, voxels).empty();
  });
}

VoxelBox DeformedVolume::elements_over(const VoxelBox& voxels) const {
  VoxelBox cells{voxels.lo - 1, voxels.hi};
  for (const Entry& entry : entries) {
    if (intersection(entry.covered, voxels).empty()) continue;
    cells =
        united(cells, cells_over(entry.reach, glm::dvec3(voxels.lo), glm::dvec3(voxels.hi - 1)));
  }
  return intersection({cells.lo, cells.hi + 2}, {VoxelIndex(0), size()});
}

std::optional<glm::ivec3> DeformedVolume::whole_shift(std::int64_t brick) const {
  const BrickGrid& grid = lattice.grid();
  const LatticeBrick* const here = lattice.brick(brick);
  if (!here || cuts.brick(brick) || cut_in_sight(box(brick))) return std::nullopt;
  const glm::ivec3 u = here->lowest();
  if (u % kUnitsPerVoxel != glm::ivec3(0)) return std::nullopt;
  const VoxelBox elements = elements_over(box(brick));
  // What would come from elsewhere does not: nothing there can reach so far.
  const glm::ivec3 shift = u / kUnitsPerVoxel;
  const VoxelBox from =
      intersection({box(brick).lo - shift, box(brick).hi - shift}, {VoxelIndex(0), size()});
  if (!from.empty() && intersection(from, elements) != from) return std::nullopt;
  const BrickIndex lo = BrickGrid::brick_of(elements.lo);
  const BrickIndex hi = BrickGrid::brick_of(elements.hi - 1);
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x) {
        const LatticeBrick* const other = lattice.brick(grid.linear({x, y, z}));
        if (!other || other->lowest() != u || other->highest() != u) return std::nullopt;
      }
    }
  }
  return shift;
}

VoxelBox cells_over(const Reach& reach, glm::dvec3 lo, glm::dvec3 hi) {
  VoxelBox cells;
  for (int c = 0; c < 3; ++c) {
    const double most = static_cast<double>(reach.u_highest[c]) / kUnitsPerVoxel;
    const double least_u = static_cast<double>(reach.u_lowest[c]) / kUnitsPerVoxel;
    const double first = std::ceil(lo[c] - 1.0 - most - 1e-6);
    const double last = std::floor(hi[c] - least_u + 1e-6);
    cells.lo[c] = std::max(reach.cells.lo[c], static_cast<int>(std::clamp(first, -1e9, 1e9)));
    cells.hi[c] = std::min(reach.cells.hi[c], static_cast<int>(std::clamp(last, -1e9, 1e9)) + 1);
  }
  return cells;
}

}  // namespace maille
