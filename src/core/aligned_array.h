// An array on a cache line of its own whose elements start undefined: what SIMD rows live in.
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <type_traits>

namespace maille {

inline constexpr std::size_t kCacheLine = 64;

struct AlignedDelete {
  void operator()(void* memory) const { ::operator delete (memory, std::align_val_t{kCacheLine}); }
};

template <class T>
using AlignedArray = std::unique_ptr<T[], AlignedDelete>;

// Throws std::bad_alloc.
template <class T>
AlignedArray<T> make_aligned_array(std::size_t count) {
  static_assert(std::is_trivially_default_constructible_v<T> &&
                std::is_trivially_destructible_v<T>);
  return AlignedArray<T>(
      static_cast<T*>(::operator new (count * sizeof(T), std::align_val_t{kCacheLine})));
}

}  // namespace maille
