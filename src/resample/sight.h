// What of a deformed volume can have to do with a box of voxels: looked for once, asked often.
#pragma once

#include <optional>
#include <vector>

#include "resample/deformed_volume.h"

namespace maille {

class Sight {
 public:
  // So far around the voxels all is in sight too.
  static constexpr int kAround_voxels = 12;

  // The volume must outlive this.
  Sight(const DeformedVolume& volume, const VoxelBox& voxels);

  const DeformedVolume& volume() const { return volume_; }

  // All of these ask for a box that is in sight.

  // Whether something has been carved from it, or cut cells may touch it.
  bool cut(const VoxelBox& part) const;
  // The smallest box of voxels around those of the part that a moved cell can cover.
  VoxelBox coverable(const VoxelBox& part) const;
  // Elements of all cells that can cover one of the voxels, and some around them.
  VoxelBox elements_over(const VoxelBox& part) const;
  // By how many whole voxels all that can cover the part is displaced, where it is that simple.
  std::optional<glm::ivec3> whole_shift(const VoxelBox& part) const;

  // Calls f(cells, entry) for boxes of cells that together are all moved ones that can cover one of
  // the voxels.
  template <class F>
  void for_each_cells_over(const VoxelBox& part, F&& f) const {
    for (const DeformedVolume::Entry* entry : entries_) {
      const VoxelBox cells = entry->cover.cells_over(part);
      if (!cells.empty()) f(cells, *entry);
    }
  }

 private:
  bool rests_somewhere(const VoxelBox& elements) const;

  const DeformedVolume& volume_;
  std::vector<const DeformedVolume::Entry*> entries_;  // by rising brick
};

}  // namespace maille
