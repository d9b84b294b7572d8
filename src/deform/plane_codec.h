// The values of a plane in a few bytes, for putting them aside: each value's difference from the
// one before it in its row, by bytes of one significance, deflated at level 1. Displacements vary
// slowly, so the high bytes are nearly all 0.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace maille {

// values: 32^3 integers of value_bytes each (2 or 4), x fastest. Throws std::bad_alloc.
std::vector<std::byte> pack_plane(std::span<const std::byte> values, int value_bytes);
// False: these are not the bytes of such a plane.
bool unpack_plane(std::span<const std::byte> packed, std::span<std::byte> values, int value_bytes);

}  // namespace maille
