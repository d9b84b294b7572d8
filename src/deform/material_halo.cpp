#include "deform/material_halo.h"

namespace maille {

MaterialHalos::MaterialHalos(const MaterialField& materials, const BrickGrid& grid)
    : materials_(materials), grid_(grid), halos_(static_cast<std::size_t>(grid.count())) {}

const MaterialHalo& MaterialHalos::of(std::int64_t brick) {
  auto& halo = halos_[static_cast<std::size_t>(brick)];
  if (!halo) {
    halo = std::make_unique<MaterialHalo>();
    const VoxelBox box = grid_.box(grid_.brick(brick));
    halo->box = {glm::max(box.lo - 1, VoxelIndex(0)), glm::min(box.hi + 1, materials_.size())};
    halo->ids.resize(static_cast<std::size_t>(voxel_count(halo->box.size())));
    halo->uniform = materials_.read(halo->box, halo->ids);
  }
  return *halo;
}

}  // namespace maille
