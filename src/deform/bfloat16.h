// The upper half of a float: its range with 8 bits of precision, for what need not be exact.
#pragma once

#include <bit>
#include <cstdint>

namespace maille {

struct Bfloat16 {
  std::uint16_t bits;

  Bfloat16() = default;
  // To the nearest, ties to even; finite values only.
  explicit Bfloat16(float value) {
    const auto all = std::bit_cast<std::uint32_t>(value);
    bits = static_cast<std::uint16_t>((all + 0x7fff + ((all >> 16) & 1)) >> 16);
  }
  explicit operator float() const {
    return std::bit_cast<float>(static_cast<std::uint32_t>(bits) << 16);
  }
};

}  // namespace maille
