#include "resample/claims.h"

#include "resample/resting_elements.h"

namespace maille {

std::int64_t BrickClaims::open(const DeformedVolume& volume, const VoxelBox& voxels) {
  const auto count = static_cast<std::size_t>(voxel_count(voxels.size()));
  score.resize(count);
  element.resize(count);
  rest.resize(count);
  const RestingElements resting(volume, voxels);
  const CutBrick* const cuts_here = volume.cuts_at(voxels.lo);
  cut.clear();
  if (cuts_here) cut.assign(count, 0);
  std::int64_t open = 0;
  std::size_t i = 0;
  for (int z = voxels.lo.z; z < voxels.hi.z; ++z) {
    for (int y = voxels.lo.y; y < voxels.hi.y; ++y) {
      const std::uint32_t owned = resting.row(y, z);
      const int element_of_row = element_in_brick({voxels.lo.x, y, z});
      const std::uint32_t carved =
          cuts_here ? cuts_here->carved[static_cast<std::size_t>(element_of_row / kBrickEdge)] >>
                          (element_of_row % kBrickEdge)
                    : 0;
      std::int64_t own = linear_index({voxels.lo.x, y, z}, volume.size());
      for (int x = 0; x < voxels.size().x; ++x, ++i, ++own) {
        const bool rests = (owned >> x & 1) != 0;
        if ((carved >> x & 1) != 0) cut[i] = may_be_open;
        score[i] = rests ? kOwned : kUncovered;
        element[i] = rests ? own : std::numeric_limits<std::int64_t>::max();
        rest[i] = rests ? glm::vec3(voxels.lo.x + x, y, z)
                        : glm::vec3(std::numeric_limits<float>::quiet_NaN());
        open += !rests;
      }
    }
  }
  return open;
}

}  // namespace maille
