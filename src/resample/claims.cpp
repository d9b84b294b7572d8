#include "resample/claims.h"

#include <algorithm>

namespace maille {

glm::vec3 rest_in_cell(VoxelIndex base, glm::vec3 t, Size3 size) {
  glm::vec3 rest;
  for (int c = 0; c < 3; ++c) {
    const auto b = static_cast<float>(base[c]);
    rest[c] = base[c] < 0              ? -0.5f + 0.5f * t[c]
              : base[c] == size[c] - 1 ? b + 0.5f * t[c]
                                       : b + t[c];
  }
  return rest;
}

float score_of(glm::vec3 t, Float4 element_at, glm::vec3 point, const DeformedVolume& volume) {
  const glm::vec3 outside = glm::max(-t, t - 1.0f);
  const float excess = std::max({outside.x, outside.y, outside.z});
  if (excess > kInside_cells) return kMissPenalty * (1.0f + excess);
  const glm::vec3 at(element_at[0], element_at[1], element_at[2]);
  const glm::vec3 away = (at - point) * volume.spacing_mm;
  return glm::dot(away, away);
}

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
