// The displacements of a brick's elements and of the next ones along each axis: both ends of all
// the links that belong to the brick.
#pragma once

#include <array>
#include <vector>

#include "deform/lattice.h"

namespace maille {

class BrickCorner {
 public:
  // Reads anew; the memory is kept from brick to brick.
  void read(const Lattice& lattice, std::int64_t brick);

  // The brick's elements in the volume, and those with the next ones.
  const VoxelBox& box() const { return box_; }
  const VoxelBox& with_next() const { return with_next_; }
  bool at_rest() const { return at_rest_; }

  glm::ivec3 u(VoxelIndex in_box) const {  // counted from box().lo
    if (at_rest_) return glm::ivec3(0);
    const auto i = static_cast<std::size_t>(linear_index(in_box, with_next_.size()));
    return {u_[0][i], u_[1][i], u_[2][i]};
  }

 private:
  void read_elements(const Lattice& lattice);

  VoxelBox box_;
  VoxelBox with_next_;
  bool at_rest_ = true;
  std::array<std::vector<std::int32_t>, 3> u_;
};

}  // namespace maille
