#include "resample/claims.h"

namespace maille {

std::int64_t BrickClaims::open(const DeformedVolume& volume, std::int64_t brick) {
  score.resize(kBrickVoxels);
  element.resize(kBrickVoxels);
  rest.resize(kBrickVoxels);
  const BrickGrid& grid = volume.lattice.grid();
  const VoxelBox box = grid.box(grid.brick(brick));
  const LatticeBrick* here = volume.lattice.brick(brick);
  const CutBrick* cuts_here = volume.cuts.brick(brick);
  cut.clear();
  if (cuts_here) cut.assign(kBrickVoxels, 0);
  std::int64_t open = 0;
  std::size_t i = 0;
  for (int z = box.lo.z; z < box.hi.z; ++z) {
    for (int y = box.lo.y; y < box.hi.y; ++y) {
      const int row = element_in_brick({box.lo.x, y, z});
      std::int64_t own = linear_index({box.lo.x, y, z}, volume.size());
      std::int32_t u[3][kBrickEdge] = {};
      for (int c = 0; here && c < 3; ++c) here->read_row(c, row / kBrickEdge, u[c]);
      const std::uint32_t carved =
          cuts_here ? cuts_here->carved[static_cast<std::size_t>(row / kBrickEdge)] : 0;
      for (int x = box.lo.x; x < box.hi.x; ++x, ++i, ++own) {
        const int in_row = x - box.lo.x;
        const bool is_carved = (carved >> in_row & 1) != 0;
        const bool rests = (u[0][in_row] | u[1][in_row] | u[2][in_row]) == 0 && !is_carved;
        if (is_carved) cut[i] = may_be_open;
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
