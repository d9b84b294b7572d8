#include "deform/plane_codec.h"

#include <cstdint>
#include <cstring>
#include <new>

#include <zlib.h>

#include "volume/brick.h"

namespace maille {
namespace {

// One value to the next, the first of a row to the first of the row before: differences wrap.
template <class T>
std::vector<std::byte> differences(const std::byte* values) {
  constexpr std::size_t kCount = kBrickVoxels;
  std::vector<std::byte> out(kCount * sizeof(T));
  T row_first = 0;
  T before = 0;
  for (std::size_t e = 0; e < kCount; ++e) {
    T value;
    std::memcpy(&value, values + e * sizeof(T), sizeof(T));
    if (e % kBrickEdge == 0) before = row_first;
    const auto difference = static_cast<T>(value - before);
    if (e % kBrickEdge == 0) row_first = value;
    before = value;
    for (std::size_t b = 0; b < sizeof(T); ++b) {
      out[b * kCount + e] = static_cast<std::byte>(difference >> (8 * b));
    }
  }
  return out;
}

template <class T>
void sums(const std::vector<std::byte>& differences, std::byte* values) {
  constexpr std::size_t kCount = kBrickVoxels;
  T row_first = 0;
  T before = 0;
  for (std::size_t e = 0; e < kCount; ++e) {
    T difference = 0;
    for (std::size_t b = 0; b < sizeof(T); ++b) {
      const auto byte = static_cast<T>(differences[b * kCount + e]);
      difference = static_cast<T>(difference | static_cast<T>(byte << (8 * b)));
    }
    if (e % kBrickEdge == 0) before = row_first;
    const auto value = static_cast<T>(before + difference);
    if (e % kBrickEdge == 0) row_first = value;
    before = value;
    std::memcpy(values + e * sizeof(T), &value, sizeof(T));
  }
}

}  // namespace

std::vector<std::byte> pack_plane(std::span<const std::byte> values, int value_bytes) {
  const auto plain = value_bytes == 2 ? differences<std::uint16_t>(values.data())
                                      : differences<std::uint32_t>(values.data());
  auto length = compressBound(static_cast<uLong>(plain.size()));
  std::vector<std::byte> packed(length);
  const int done =
      compress2(reinterpret_cast<Bytef*>(packed.data()), &length,
                reinterpret_cast<const Bytef*>(plain.data()), static_cast<uLong>(plain.size()), 1);
  if (done != Z_OK) throw std::bad_alloc();  // the one way it can fail
  packed.resize(length);
  return packed;
}

bool unpack_plane(std::span<const std::byte> packed, std::span<std::byte> values, int value_bytes) {
  std::vector<std::byte> plain(values.size());
  auto length = static_cast<uLongf>(plain.size());
  const int done =
      uncompress(reinterpret_cast<Bytef*>(plain.data()), &length,
                 reinterpret_cast<const Bytef*>(packed.data()), static_cast<uLong>(packed.size()));
  if (done == Z_MEM_ERROR) throw std::bad_alloc();
  if (done != Z_OK || length != plain.size()) return false;
  if (value_bytes == 2) {
    sums<std::uint16_t>(plain, values.data());
  } else {
    sums<std::uint32_t>(plain, values.data());
  }
  return true;
}

}  // namespace maille
