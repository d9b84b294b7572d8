// An array on a cache line of its own whose elements start undefined: what SIMD rows live in.
//
// Freed blocks of the sizes that bricks take are kept for the next one, up to a bound: a drag frees
// at every position of the pointer what it makes again at the next, and fresh pages from the system
// cost more than what is done in them.
//
// Large arrays ask the system for large pages: a gigabyte in small ones takes 0.2 s to give back,
// and meanwhile no other thread gets memory from the system (3 ms in large ones; measured).
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <new>
#include <type_traits>

namespace maille {

inline constexpr std::size_t kCacheLine = 64;

namespace detail {
void* take_block(std::size_t bytes);  // throws std::bad_alloc
void give_block_back(void* block, std::size_t bytes) noexcept;
}  // namespace detail

// From here on an array is a mapping of its own.
inline constexpr std::size_t kLargeBytes = std::size_t{4} << 20;

// Bytes of freed blocks that are kept, at most.
inline constexpr std::size_t kMostKeptBytes = std::size_t{64} << 20;
std::size_t kept_block_bytes();  // now

struct AlignedDelete {
  std::size_t bytes = 0;
  void operator()(void* memory) const noexcept { detail::give_block_back(memory, bytes); }
};

template <class T>
using AlignedArray = std::unique_ptr<T[], AlignedDelete>;

// Throws std::bad_alloc.
template <class T>
AlignedArray<T> make_aligned_array(std::size_t count) {
  static_assert(std::is_trivially_default_constructible_v<T> &&
                std::is_trivially_destructible_v<T>);
  constexpr std::size_t kMostBytes = std::numeric_limits<std::size_t>::max() / 2;  // of an object
  if (count > kMostBytes / sizeof(T)) throw std::bad_alloc();
  const std::size_t bytes = count * sizeof(T);
  return AlignedArray<T>(static_cast<T*>(detail::take_block(bytes)), AlignedDelete{bytes});
}

}  // namespace maille
