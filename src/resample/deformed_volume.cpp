#include "resample/deformed_volume.h"

#include <algorithm>
#include <cmath>

namespace maille {

DeformedVolume::DeformedVolume(Lattice deformed, glm::dvec3 spacing)
    : lattice(std::move(deformed)), spacing_mm(spacing) {
  lattice.for_each_brick([&](std::int64_t b, const LatticeBrick&) {
    const Reach reach = reach_of(lattice, b);
    // The moved box is tight: where it touches the border, an element there has moved.
    const bool at_border = glm::any(glm::lessThan(reach.cells.lo, VoxelIndex(0))) ||
                           glm::any(glm::equal(reach.cells.hi, VoxelIndex(size())));
    entries.push_back({reach, reach.covered(size()), at_border});
    border_moved = border_moved || at_border;
  });
}

// Those of a reach's cells whose bounds allow them to touch a box of points.
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

std::int64_t BrickClaims::open(const DeformedVolume& volume, std::int64_t brick) {
  score.resize(kBrickVoxels);
  element.resize(kBrickVoxels);
  rest.resize(kBrickVoxels);
  const BrickGrid& grid = volume.lattice.grid();
  const VoxelBox box = grid.box(grid.brick(brick));
  const LatticeBrick* here = volume.lattice.brick(brick);
  std::int64_t open = 0;
  std::size_t i = 0;
  for (int z = box.lo.z; z < box.hi.z; ++z) {
    for (int y = box.lo.y; y < box.hi.y; ++y) {
      const int row = element_in_brick({box.lo.x, y, z});
      std::int64_t own = linear_index({box.lo.x, y, z}, volume.size());
      std::int32_t u[3][kBrickEdge] = {};
      for (int c = 0; here && c < 3; ++c) here->read_row(c, row / kBrickEdge, u[c]);
      for (int x = box.lo.x; x < box.hi.x; ++x, ++i, ++own) {
        const int in_row = x - box.lo.x;
        const bool rests = (u[0][in_row] | u[1][in_row] | u[2][in_row]) == 0;
        score[i] = rests ? kOwned : kUncovered;
        element[i] = rests ? own : std::numeric_limits<std::int64_t>::max();
        rest[i] = rests ? glm::vec3(x, y, z) : glm::vec3(std::numeric_limits<float>::quiet_NaN());
        open += !rests;
      }
    }
  }
  return open;
}

}  // namespace maille
