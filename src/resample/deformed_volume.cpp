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
