// The lattice: the displacement u of every element (voxel), x = X + u.
//
// Displacements are fixed-point integers of 1/512 voxel, so that sums are exact and any order of
// work gives the same bits. 32 bits reach 4 million voxels. Bricks are made only where something
// moved; an absent brick is at rest (u = 0).
//
// Bricks are immutable once in a lattice and shared between its copies: a copy costs a pointer a
// brick, so the state at button-down, undo steps and what a reader on another thread looks at are
// plain copies that keep only what differs.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "material/material_table.h"
#include "volume/brick.h"

namespace maille {

struct LatticeBrick {
  // By element, x fastest, stride 32 and 1024, [component][element]. Elements beyond the volume's
  // border are 0.
  std::int32_t u[3][kBrickVoxels];
  // Least and greatest u over the elements that lie in the volume, and the box of those with u != 0
  // (voxels of the volume, empty when all are at rest).
  glm::ivec3 lowest{0};
  glm::ivec3 highest{0};
  VoxelBox moved;

  bool at_rest() const { return moved.empty(); }
  void update_bounds(const VoxelBox& box);
};

inline int element_in_brick(VoxelIndex voxel) {
  return ((voxel.z & 31) * kBrickEdge + (voxel.y & 31)) * kBrickEdge + (voxel.x & 31);
}

class Lattice {
 public:
  Lattice() = default;
  explicit Lattice(Size3 volume_size)
      : grid_(volume_size), bricks_(static_cast<std::size_t>(grid_.count())) {}

  const BrickGrid& grid() const { return grid_; }
  const LatticeBrick* brick(std::int64_t linear) const {
    return bricks_[static_cast<std::size_t>(linear)].get();
  }
  const std::shared_ptr<const LatticeBrick>& shared(std::int64_t linear) const {
    return bricks_[static_cast<std::size_t>(linear)];
  }
  // A brick at rest is stored as none.
  void set(std::int64_t linear, std::shared_ptr<const LatticeBrick> brick);

  glm::ivec3 u(VoxelIndex voxel) const;  // fixed point; voxel must lie inside
  glm::dvec3 displacement_voxels(VoxelIndex voxel) const {
    return glm::dvec3(u(voxel)) / double{kUnitsPerVoxel};
  }

  std::int64_t brick_count() const;  // bricks that hold elements
  std::int64_t bytes() const { return brick_count() * std::int64_t{sizeof(LatticeBrick)}; }
  bool at_rest() const { return brick_count() == 0; }

 private:
  BrickGrid grid_;
  std::vector<std::shared_ptr<const LatticeBrick>> bricks_;
};

// Links whose two elements are outside their limits, counted over the bricks that hold elements and
// the ones beside them. Knows nothing of how the lattice was made.
struct Violations {
  std::int64_t links = 0;
  double worst_voxels = 0.0;
};
class MaterialField;
Violations violations_of(const Lattice& lattice, const MaterialField& materials);

}  // namespace maille
