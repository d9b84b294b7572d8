// Which voxels belong to an element at rest: nothing else may claim them.
#pragma once

#include <cstdint>

#include "resample/deformed_volume.h"

namespace maille {

class RestingElements {
 public:
  // voxels: of one brick, of the volume or beyond it. The volume must outlive this.
  RestingElements(const DeformedVolume& volume, const VoxelBox& voxels);

  // Bit x: the element of voxel x of a row is neither moved nor carved. Beyond the volume there is
  // none.
  std::uint32_t row(int y, int z) const;

 private:
  const VoxelBox voxels_;
  VoxelBox inside_;  // the volume
  const LatticeBrick* brick_ = nullptr;
  const CutBrick* cuts_ = nullptr;
};

}  // namespace maille
