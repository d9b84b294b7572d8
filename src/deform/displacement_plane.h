// One component of the displacement of a brick's elements, as small as its values allow.
//
// Fixed-point integers of 1/512 voxel. Where all elements agree the plane is one number; where they
// lie within 128 voxels of one another it is 2 bytes an element beside a common base; 4 bytes only
// beyond that. A brick that a drag along one axis moved costs 2 bytes an element (the paper: 64).
//
// Where lattice memory has a budget, the values live in a PlaneStore, which may put them aside: the
// first read of a row or element brings them back (and throws Failure where the file gives nothing
// back). Range and box stay.
#pragma once

#include <cstdint>
#include <memory>

#include "core/aligned_array.h"
#include "deform/plane_store.h"
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
    if (paged_) [[unlikely]]
      return at_paged(e);
    if (offsets_) return base_ + step_ * offsets_[e];
    return wide_ ? wide_[e] : base_;
  }
  // So many values of a row from an element on.
  void read_row(int first, int count, std::int32_t* u) const;

  // Over the elements in the volume; and the box of those with u != 0, in voxels of the volume.
  std::int32_t lowest() const { return lowest_; }
  std::int32_t highest() const { return highest_; }
  const VoxelBox& moved() const { return moved_; }

  bool constant() const { return !offsets_ && !wide_ && !paged_; }
  std::int64_t array_bytes() const;  // of the values, in memory or put aside
  std::int64_t bytes() const;        // of all of it, in memory now

  // From here on the values are the store's. Call before any other thread knows the plane, for
  // planes that are not constant; a second call does nothing.
  void page_through(const std::shared_ptr<PlaneStore>& store) const;
  const PagedArray* paged() const { return paged_.get(); }  // null: they are not

 private:
  std::int32_t at_paged(std::size_t element) const;

  std::int32_t base_ = 0;
  std::int32_t step_ = 1;  // labels of a drag downwards are offsets downwards, and stay as they are
  // At most one of the three. Mutable, for it is only where they lie that page_through() changes.
  mutable AlignedArray<std::uint16_t> offsets_;
  mutable AlignedArray<std::int32_t> wide_;
  mutable std::unique_ptr<const PagedArray> paged_;
  std::int32_t lowest_ = 0;
  std::int32_t highest_ = 0;
  VoxelBox moved_;
};

}  // namespace maille
