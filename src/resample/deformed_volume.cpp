#include "resample/deformed_volume.h"

#include "resample/cut_rows.h"

namespace maille {

DeformedVolume::DeformedVolume(Lattice deformed, Cuts with_cuts, glm::dvec3 spacing, CellMap map)
    : lattice(std::move(deformed)), cuts(std::move(with_cuts)), spacing_mm(spacing), cell_map(map) {
  any_cut = !cuts.empty();
  lattice.for_each_brick([&](std::int64_t b, const LatticeBrick&) {
    const Reach reach = reach_of(lattice, b);
    // The moved box is tight: where it touches the border, an element there has moved.
    const bool at_border = glm::any(glm::lessThan(reach.cells.lo, VoxelIndex(0))) ||
                           glm::any(glm::equal(reach.cells.hi, VoxelIndex(size())));
    const bool cut = any_cut && CutRows(cuts, reach.cells).any();
    entries.push_back({CellCover(lattice, reach, cut), at_border, cut});
    border_moved = border_moved || at_border;
  });
}

const LatticeBrick* DeformedVolume::moved_at(VoxelIndex voxel) const {
  const BrickIndex brick = BrickGrid::brick_of(voxel);
  const BrickGrid& grid = lattice.grid();
  return grid.contains(brick) ? lattice.brick(grid.linear(brick)) : nullptr;
}

const CutBrick* DeformedVolume::cuts_at(VoxelIndex voxel) const {
  const BrickIndex brick = BrickGrid::brick_of(voxel);
  const BrickGrid& grid = lattice.grid();
  return grid.contains(brick) ? cuts.brick(grid.linear(brick)) : nullptr;
}

}  // namespace maille
