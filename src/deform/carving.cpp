#include "deform/carving.h"

#include "deform/cuts_edit.h"
#include "deform/lattice_reach.h"

namespace maille {
namespace {

struct Ball {
  glm::dvec3 center_voxel;
  double radius_voxels;

  bool contains(glm::dvec3 place_voxel) const {
    const glm::dvec3 offset = place_voxel - center_voxel;
    return glm::dot(offset, offset) <= radius_voxels * radius_voxels;
  }
};

// Calls f(voxel) for the elements that lie in a ball.
template <class F>
void for_each_element_in(const Ball& ball, const Lattice& lattice, F&& f) {
  if (!(ball.radius_voxels >= 0.0)) return;
  const BrickGrid& grid = lattice.grid();
  const SpaceBox around{ball.center_voxel - ball.radius_voxels,
                        ball.center_voxel + ball.radius_voxels};
  for (const std::int64_t b : bricks_with_links_in(around, lattice)) {
    const LatticeBrick* brick = lattice.brick(b);
    const glm::ivec3 lowest = brick ? brick->lowest() : glm::ivec3(0);
    const glm::ivec3 highest = brick ? brick->highest() : glm::ivec3(0);
    // Distances are rounded: one voxel more, so that the ball itself decides.
    const VoxelBox range =
        rest_range({around.lo - 1.0, around.hi + 1.0}, grid.box(grid.brick(b)), lowest, highest);
    for (int z = range.lo.z; z < range.hi.z; ++z) {
      for (int y = range.lo.y; y < range.hi.y; ++y) {
        for (int x = range.lo.x; x < range.hi.x; ++x) {
          const VoxelIndex voxel{x, y, z};
          glm::dvec3 place(voxel);
          if (brick)
            place += glm::dvec3(brick->u(element_in_brick(voxel))) / double{kUnitsPerVoxel};
          if (ball.contains(place)) f(voxel);
        }
      }
    }
  }
}

}  // namespace

Cuts carve(const Cuts& cuts, const Lattice& lattice, glm::dvec3 center_voxel,
           double radius_voxels) {
  CutsEdit edit(cuts);
  for_each_element_in({center_voxel, radius_voxels}, lattice, [&](VoxelIndex voxel) {
    edit.set_carved(voxel, true);
    for_each_link(voxel, cuts.grid().volume_size(), [&](VoxelIndex lower, int axis, VoxelIndex) {
      edit.set_removed(lower, axis, true);
    });
  });
  return edit.finish();
}

Cuts restore(const Cuts& cuts, const Lattice& lattice, glm::dvec3 center_voxel,
             double radius_voxels) {
  if (cuts.empty()) return cuts;
  const Ball ball{center_voxel, radius_voxels};
  CutsEdit edit(cuts);
  for_each_element_in(ball, lattice, [&](VoxelIndex voxel) { edit.set_carved(voxel, false); });
  for_each_element_in(ball, lattice, [&](VoxelIndex voxel) {
    for_each_link(voxel, cuts.grid().volume_size(),
                  [&](VoxelIndex lower, int axis, VoxelIndex other) {
                    if (!edit.carved(other)) edit.set_removed(lower, axis, false);
                  });
  });
  return edit.finish();
}

}  // namespace maille
