#include "resample/near_bricks.h"

#include <algorithm>

#include "resample/reach.h"

namespace maille {
namespace {

// Half the diagonal of what bounds a cell, in voxels along each axis; what is left of a cut one
// reaches half a voxel further.
glm::ivec3 half_diagonal_voxels(glm::ivec3 spread, glm::dvec3 spacing_mm) {
  const glm::dvec3 cell_mm = (1.0 + glm::dvec3(spread) / double{kUnitsPerVoxel}) * spacing_mm;
  return glm::ivec3(glm::ceil(0.5 * glm::length(cell_mm) / spacing_mm)) + 1;
}

}  // namespace

NearBricks::NearBricks(const Lattice& lattice, glm::dvec3 spacing_mm, const VoxelBox& extent)
    : extent_(extent),
      grid_(extent.size()),
      furthest_voxels_(half_diagonal_voxels(glm::ivec3(0), spacing_mm)),
      around_voxels_(static_cast<std::size_t>(grid_.count()), furthest_voxels_) {
  lattice.for_each_brick([&](std::int64_t b, const LatticeBrick&) {
    const Reach reach = reach_of(lattice, b);
    const glm::ivec3 around = half_diagonal_voxels(reach.u_highest - reach.u_lowest, spacing_mm);
    furthest_voxels_ = glm::max(furthest_voxels_, around);
    for_each_brick_over(
        shifted(intersection(reach.covered(), extent_), -extent_.lo), [&](BrickIndex brick) {
          auto& of_brick = around_voxels_[static_cast<std::size_t>(grid_.linear(brick))];
          of_brick = glm::max(of_brick, around);
        });
  });
}

void NearBricks::add(const VoxelBox& voxels, BrickSet& to) const {
  const VoxelBox here = shifted(voxels, -extent_.lo);
  const VoxelBox shown{VoxelIndex(0), extent_.size()};
  const VoxelBox most =
      intersection({here.lo - furthest_voxels_, here.hi + furthest_voxels_}, shown);
  for_each_brick_over(most, [&](BrickIndex brick) {
    const std::int64_t b = grid_.linear(brick);
    const glm::ivec3 around = around_voxels_[static_cast<std::size_t>(b)];
    const VoxelBox near{here.lo - around, here.hi + around};
    if (!intersection(near, grid_.box(brick)).empty()) to.add(b);
  });
}

}  // namespace maille
