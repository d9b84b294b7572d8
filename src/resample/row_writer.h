// Rows of voxels into memory that is written once, in order, and not read: mapped staging, a file.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <type_traits>

#include "core/nearest_whole.h"
#include "volume/brick.h"

namespace maille {

// The nearest value of a voxel type.
template <class T>
T stored(double value) {
  if constexpr (std::is_integral_v<T>) {
    const double rounded = std::nearbyint(value);
    return static_cast<T>(std::clamp(rounded, double{std::numeric_limits<T>::lowest()},
                                     double{std::numeric_limits<T>::max()}));
  } else {
    return static_cast<T>(value);
  }
}

// The same, many at a time: floats tell all integers of the types that volumes have.
template <class T>
T stored_float(float value) {
  if constexpr (std::is_integral_v<T>) {
    static_assert(sizeof(T) <= 2);
    constexpr auto kLowest = static_cast<float>(std::numeric_limits<T>::lowest());
    constexpr auto kMost = static_cast<float>(std::numeric_limits<T>::max());
    const float whole = nearest_whole(std::min(std::max(value, kLowest), kMost));
    return static_cast<T>(static_cast<std::int32_t>(whole));
  } else {
    return value;
  }
}

template <class T>
class RowWriter {
 public:
  // flip_sign_bit stores signed integers offset, as unsigned textures want them.
  RowWriter(std::span<std::byte> out, bool flip_sign_bit)
      : to_(out.data()), flip_(flip_sign_bit && std::is_integral_v<T>) {}

  // At most a brick's row.
  void write(const T* row, int count) {
    T flipped[kBrickEdge];
    if constexpr (std::is_integral_v<T>) {
      if (flip_) {
        using Bits = std::make_unsigned_t<T>;
        constexpr Bits kSign = static_cast<Bits>(Bits{1} << (8 * sizeof(T) - 1));
        for (int x = 0; x < count; ++x) {
          flipped[x] = static_cast<T>(static_cast<Bits>(row[x]) ^ kSign);
        }
        row = flipped;
      }
    }
    const std::size_t bytes = static_cast<std::size_t>(count) * sizeof(T);
    std::memcpy(to_, row, bytes);
    to_ += bytes;
  }

 private:
  std::byte* to_;
  bool flip_;
};

}  // namespace maille
