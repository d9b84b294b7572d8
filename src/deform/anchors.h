// What does not move.
//
// Stated faces of the volume, fixed materials and pinned handles hold in ChainMail and in
// relaxation. Where no faces are stated the elements of all border faces hold, in relaxation only,
// the place where ChainMail left them: a pulled nose must not drag the whole head along.
#pragma once

#include <bitset>
#include <memory>
#include <unordered_map>

#include "deform/lattice.h"

namespace maille {

// A set of elements, brick by brick.
class ElementSet {
 public:
  using Mask = std::bitset<kBrickVoxels>;

  void insert(VoxelIndex voxel, const BrickGrid& grid);
  bool contains(VoxelIndex voxel, const BrickGrid& grid) const;
  const Mask* brick(std::int64_t linear) const;
  bool empty() const { return masks_.empty(); }
  bool intersects(const ElementSet& other) const;
  void insert(const ElementSet& other);
  const std::unordered_map<std::int64_t, std::unique_ptr<Mask>>& bricks() const { return masks_; }

  ElementSet() = default;
  ElementSet(const ElementSet& other) { insert(other); }
  ElementSet& operator=(const ElementSet& other);
  ElementSet(ElementSet&&) noexcept = default;
  ElementSet& operator=(ElementSet&&) noexcept = default;

 private:
  std::unordered_map<std::int64_t, std::unique_ptr<Mask>> masks_;
};

// The elements within radius_voxels of a voxel, in rest space, clipped to the volume. The centre is
// always in it.
ElementSet ball_of_elements(VoxelIndex center, double radius_voxels, const BrickGrid& grid);

enum Face : std::uint8_t {
  face_low_x = 1,
  face_high_x = 2,
  face_low_y = 4,
  face_high_y = 8,
  face_low_z = 16,
  face_high_z = 32
};

struct AnchorRules {
  std::uint8_t faces = 0;    // bits of Face: stated anchors
  bool free_border = false;  // "anchors": "none": not even relaxation holds the border
};

// Bits of the faces that a voxel lies on.
std::uint8_t faces_of(VoxelIndex voxel, Size3 size);

}  // namespace maille
