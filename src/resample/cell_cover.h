// Which voxels the cells of one lattice brick can cover.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "resample/reach.h"

namespace maille {

class CellCover {
 public:
  // cut: what is left of some of the cells reaches half a voxel beyond their corners. The lattice
  // must outlive it.
  CellCover(const Lattice& lattice, const Reach& reach, bool cut);

  // From bounds alone. Of a brick whose elements moved each their own way that is much more than
  // what they cover.
  const VoxelBox& roughly() const { return covered_; }
  // The smallest box around what they cover, or nearly.
  VoxelBox closely() const;

  // The smallest boxes around the voxels, and the cells, of which one may cover the other; empty
  // where none can. Nearly tight: where bounds say little it looks at the elements, once.
  VoxelBox voxels_among(const VoxelBox& voxels) const;
  VoxelBox cells_over(const VoxelBox& voxels) const;
  // The same of one point (voxel space).
  VoxelBox cells_over(glm::dvec3 point) const;

 private:
  struct Block {
    VoxelBox cells;
    VoxelBox covered;
  };
  struct Blocks {
    std::once_flag once;
    std::vector<Block> blocks;
  };

  const std::vector<Block>& blocks() const;

  const Lattice* lattice_;
  Reach reach_;
  bool cut_;
  VoxelBox covered_;
  bool bounds_say_enough_;  // for boxes of voxels and cells
  std::unique_ptr<Blocks> blocks_;
};

}  // namespace maille
