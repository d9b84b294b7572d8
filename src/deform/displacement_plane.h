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
  // The same for u = base + offset, taking the offsets over.
  static Pointer adopt(const VoxelBox& box, std::int32_t base, AlignedArray<std::uint16_t> offsets);

  std::int32_t at(int element) const {
    const auto e = static_cast<std::size_t>(element);
    if (offsets_) return base_ + offsets_[e];
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
  AlignedArray<std::uint16_t> offsets_;  // at most one of the two
  AlignedArray<std::int32_t> wide_;
  std::int32_t lowest_ = 0;
  std::int32_t highest_ = 0;
  VoxelBox moved_;
};

}  // namespace maille
