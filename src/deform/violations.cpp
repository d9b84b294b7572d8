#include "deform/violations.h"

#include <algorithm>
#include <vector>

#include "deform/brick_corner.h"
#include "deform/lattice_reach.h"

namespace maille {

Violations violations_of(const Lattice& lattice, const MaterialField& materials, const Cuts& cuts) {
  Violations found;
  std::int64_t worst = 0;
  std::vector<MaterialId> ids(
      static_cast<std::size_t>((kBrickEdge + 1) * (kBrickEdge + 1) * (kBrickEdge + 1)));
  BrickCorner corner;
  for (const std::int64_t b : bricks_with_moved_links(lattice)) {
    corner.read(lattice, b);
    const VoxelBox& box = corner.box();
    const Size3 extent = corner.with_next().size();
    materials.read(corner.with_next(), ids);
    const bool cut_here = cuts.brick(b) != nullptr;
    const auto id = [&](VoxelIndex v) {
      return ids[static_cast<std::size_t>(linear_index(v, extent))];
    };
    for (int z = 0; z < box.size().z; ++z) {
      for (int y = 0; y < box.size().y; ++y) {
        for (int x = 0; x < box.size().x; ++x) {
          const VoxelIndex i{x, y, z};
          const glm::ivec3 u_i = corner.u(i);
          for (int axis = 0; axis < 3; ++axis) {
            VoxelIndex j = i;
            if (++j[axis] >= extent[axis]) continue;
            if (cut_here && cuts.removed(box.lo + i, axis)) continue;
            const LinkLimits limits = materials.table().link(id(i), id(j));
            const glm::ivec3 u_j = corner.u(j);
            std::int64_t excess = 0;
            for (int c = 0; c < 3; ++c) {
              const std::int64_t d = std::int64_t{u_j[c]} - u_i[c];
              excess = std::max({excess, d - limits.upper[axis][c], limits.lower[axis][c] - d});
            }
            found.links += excess > 0;
            worst = std::max(worst, excess);
          }
        }
      }
    }
  }
  found.worst_voxels = static_cast<double>(worst) / kUnitsPerVoxel;
  return found;
}

}  // namespace maille
