#include "core/aligned_array.h"

#include <array>
#include <mutex>
#include <new>
#include <vector>

namespace maille {
namespace {

// A brick of 16- and of 32-bit values.
constexpr std::array<std::size_t, 2> kKeptSizes = {std::size_t{64} << 10, std::size_t{128} << 10};

struct KeptBlocks {
  std::mutex mutex;
  std::array<std::vector<void*>, kKeptSizes.size()> free;
  std::size_t bytes = 0;
};

// Never destroyed: arrays of other statics may be freed after it would have been.
KeptBlocks& kept() {
  static KeptBlocks* const blocks = new KeptBlocks;
  return *blocks;
}

int size_class(std::size_t bytes) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return -1;  // a block used after it was freed must be found
#endif
  for (std::size_t i = 0; i < kKeptSizes.size(); ++i) {
    if (kKeptSizes[i] == bytes) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace

namespace detail {

void* take_block(std::size_t bytes) {
  if (const int i = size_class(bytes); i >= 0) {
    KeptBlocks& blocks = kept();
    const std::lock_guard lock(blocks.mutex);
    auto& free = blocks.free[static_cast<std::size_t>(i)];
    if (!free.empty()) {
      void* const block = free.back();
      free.pop_back();
      blocks.bytes -= bytes;
      return block;
    }
  }
  return ::operator new (bytes, std::align_val_t{kCacheLine});
}

void give_block_back(void* block, std::size_t bytes) noexcept {
  if (const int i = size_class(bytes); i >= 0) {
    KeptBlocks& blocks = kept();
    const std::lock_guard lock(blocks.mutex);
    if (blocks.bytes + bytes <= kMostKeptBytes) {
      try {
        blocks.free[static_cast<std::size_t>(i)].push_back(block);
        blocks.bytes += bytes;
        return;
      } catch (const std::bad_alloc&) {
        // No room to remember it by: it goes back to the system.
      }
    }
  }
  ::operator delete (block, std::align_val_t{kCacheLine});
}

}  // namespace detail

std::size_t kept_block_bytes() {
  KeptBlocks& blocks = kept();
  const std::lock_guard lock(blocks.mutex);
  return blocks.bytes;
}

}  // namespace maille
