// A value for each element of a box, x fastest, in one block of memory with room at both ends.
//
// Loops over rows read the neighbours of the outermost elements too, and throw away what they find:
// the room at the ends is zero and theirs to read.
#pragma once

#include <algorithm>
#include <array>
#include <cstring>

#include "core/aligned_array.h"
#include "core/parallel.h"
#include "core/spaces.h"

namespace maille {

template <class T>
class BoxArray {
 public:
  BoxArray() = default;
  // All zero. Throws std::bad_alloc.
  BoxArray(Size3 extent, WorkerPool& pool)
      : count_(static_cast<std::size_t>(voxel_count(extent))),
        // A plane, a row and an element to the neighbours; up to 64 more to the end of a loop.
        room_((static_cast<std::size_t>(extent.x) * static_cast<std::size_t>(extent.y + 1) + 65 +
               63) /
              64 * 64),
        values_(make_aligned_array<T>(count_ + 2 * room_)) {
    // By the workers, so that each fresh page is made by whoever is free.
    constexpr std::size_t kPiece = std::size_t{1} << 18;
    const std::size_t all = count_ + 2 * room_;
    pool.for_each(static_cast<std::int64_t>((all + kPiece - 1) / kPiece), [&](std::int64_t i, int) {
      const std::size_t begin = static_cast<std::size_t>(i) * kPiece;
      std::memset(&values_[begin], 0, std::min(kPiece, all - begin) * sizeof(T));
    });
  }

  // Of an array of the same extent.
  void take_values_of(const BoxArray& other) {
    std::memcpy(values_.get(), other.values_.get(), (count_ + 2 * room_) * sizeof(T));
  }

  explicit operator bool() const { return static_cast<bool>(values_); }
  T* data() { return values_.get() + room_; }
  const T* data() const { return values_.get() + room_; }
  T& operator[](std::int64_t element) { return data()[element]; }
  const T& operator[](std::int64_t element) const { return data()[element]; }
  std::int64_t bytes() const {
    return values_ ? static_cast<std::int64_t>((count_ + 2 * room_) * sizeof(T)) : 0;
  }

 private:
  std::size_t count_ = 0;
  std::size_t room_ = 0;
  AlignedArray<T> values_;
};

// One of x, y and z each.
using BoxVectors = std::array<BoxArray<float>, 3>;
inline BoxVectors make_box_vectors(Size3 extent, WorkerPool& pool) {
  return {BoxArray<float>(extent, pool), BoxArray<float>(extent, pool),
          BoxArray<float>(extent, pool)};
}
inline std::int64_t bytes_of(const BoxVectors& v) {
  return v[0].bytes() + v[1].bytes() + v[2].bytes();
}

}  // namespace maille
