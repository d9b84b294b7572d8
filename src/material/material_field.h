// The material of every voxel of a volume: the table applied to the values, brick by brick, on
// demand. Nothing is stored a voxel; with one material nothing is looked up either.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "material/material_table.h"
#include "volume/brick.h"
#include "volume/volume.h"

namespace maille {

class MaterialField {
 public:
  MaterialField(Volume volume, MaterialTable table);

  const MaterialTable& table() const { return table_; }
  Size3 size() const { return volume_.size(); }
  glm::dvec3 spacing_mm() const { return volume_.spacing_mm(); }

  bool single_material() const { return table_.count() == 1; }

  MaterialId at(VoxelIndex voxel) const;  // voxel must lie inside

  // Materials of the voxels of a box inside the volume, x fastest. Returns the one material of the
  // whole box if it has only one; ids is filled either way.
  std::optional<MaterialId> read(const VoxelBox& box, std::span<MaterialId> ids) const;

 private:
  Volume volume_;
  MaterialTable table_;
  std::vector<MaterialId> id_of_stored_;  // by the 8 or 16 bits of a sample; empty for floats
};

}  // namespace maille
