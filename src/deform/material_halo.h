// Materials of a brick and of the elements one step around it: what a solver of links reads.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "material/material_field.h"
#include "volume/brick.h"

namespace maille {

struct MaterialHalo {
  VoxelBox box;  // the brick and one element around it, clipped to the volume
  std::vector<MaterialId> ids;
  std::optional<MaterialId> uniform;  // the one material of all of it

  // The ids from a voxel on, along x.
  const MaterialId* row(VoxelIndex voxel) const {
    return &ids[static_cast<std::size_t>(linear_index(voxel - box.lo, box.size()))];
  }
  MaterialId at(VoxelIndex voxel) const { return *row(voxel); }
};

// Read once a brick, when first asked for: a stroke comes back to the same bricks at every position
// of the pointer. 40 KB a brick, kept as long as the stroke. Not for several threads.
class MaterialHalos {
 public:
  // The field must outlive this and keep its table.
  MaterialHalos(const MaterialField& materials, const BrickGrid& grid);

  const MaterialTable& table() const { return materials_.table(); }
  const MaterialHalo& of(std::int64_t brick);

 private:
  const MaterialField& materials_;
  BrickGrid grid_;
  std::vector<std::unique_ptr<MaterialHalo>> halos_;
};

}  // namespace maille
