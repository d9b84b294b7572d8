// One component of the displacement of a brick's elements, as small as its values allow.
//
// Fixed-point integers of 1/512 voxel. Where all elements agree the plane is one number; where they
// lie within 128 voxels of one another it is 2 bytes an element beside a common base; 4 bytes only
// beyond that. A brick that a drag along one axis moved costs 2 bytes an element (the paper: 64).
#pragma once

#include <cstdint>
#include <memory>

#include "core/aligned_array.h"
#include "volume/brick.h"

namespace maille {

class DisplacementPlane {
 public:
  using Pointer = std::shared_ptr<const DisplacementPlane>;

  // u: 32^3 values, x fastest. Only the elements of `box` (the brick's, in the volume) count; what
  // the others read afterwards is not specified. Null where all of them rest.
  static Pointer encode(const VoxelBox& box, const std::int32_t* u);
  // What is known of a plane that is handed over: never null, as something in it has moved.
  struct Known {
    std::int32_t base = 0;
    std::int32_t step = 1;  // 1 or -1: u = base + step * offset
    std::int32_t lowest = 0;
    std::int32_t highest = 0;
    VoxelBox moved;
  };
  static Pointer adopt(const Known& known, AlignedArray<std::uint16_t> offsets);

  std::int32_t at(int element) const {
    const auto e = static_cast<std::size_t>(element);
    if (offsets_) return base_ + step_ * offsets_[e];
    return wide_ ? wide_[e] : base_;
  }
  // 32 values from a row (element 32 * row) on.
  void read_row(int row, std::int32_t* u) const;

  // Over the elements in the volume; and the box of those with u != 0, in voxels of the volume.
  std::int32_t lowest() const { return lowest_; }
  std::int32_t highest() const { return highest_; }
  const VoxelBox& moved() const { return moved_; }

  bool constant() const { return !offsets_ && !wide_; }
  std::int64_t bytes() const;

 private:
  std::int32_t base_ = 0;
  std::int32_t step_ = 1;  // labels of a drag downwards are offsets downwards, and stay as they are
  AlignedArray<std::uint16_t> offsets_;  // at most one of the two
  AlignedArray<std::int32_t> wide_;
  std::int32_t lowest_ = 0;
  std::int32_t highest_ = 0;
  VoxelBox moved_;
};

}  // namespace maille
