#include "core/aligned_array.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <mutex>
#include <new>
#include <vector>

#include <sys/mman.h>
#include <unistd.h>

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

// The sanitizers see only what they hand out themselves.
bool is_large(std::size_t bytes) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return false;
#endif
  return bytes >= kLargeBytes;
}

constexpr std::size_t kLargePage = std::size_t{2} << 20;

// Arrays that are read side by side must not all lie at the same place in a large page, or they
// would share the same few sets of every cache: each begins 65 lines further on, by turns.
std::size_t next_stagger() {
  static std::atomic<unsigned> turn{0};
  return turn.fetch_add(1, std::memory_order_relaxed) % 32 * 65 * kCacheLine;
}

// The mapping begins where a large page does, so that all of it but the end can be in such; the
// block within the first one.
void* map_block(std::size_t bytes) {
  const std::size_t stagger = next_stagger();
  if (bytes > std::numeric_limits<std::size_t>::max() / 2) throw std::bad_alloc();
  const std::size_t wanted = bytes + stagger;
  const std::size_t mapped = wanted + kLargePage;
  void* const begin =
      mmap(nullptr, mapped, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (begin == MAP_FAILED) throw std::bad_alloc();
  const auto at = reinterpret_cast<std::uintptr_t>(begin);
  const std::uintptr_t first = (at + kLargePage - 1) / kLargePage * kLargePage;
  const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  const std::uintptr_t end = (first + wanted + page - 1) / page * page;
  if (first > at) munmap(begin, first - at);
  if (at + mapped > end) munmap(reinterpret_cast<void*>(end), at + mapped - end);
  // Where there are no large pages, small ones do.
  madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
  return reinterpret_cast<void*>(first + stagger);
}

void unmap_block(void* block, std::size_t bytes) {
  const auto at = reinterpret_cast<std::uintptr_t>(block);
  const std::uintptr_t first = at / kLargePage * kLargePage;
  munmap(reinterpret_cast<void*>(first), at + bytes - first);
}

}  // namespace

namespace detail {

void* take_block(std::size_t bytes) {
  if (is_large(bytes)) return map_block(bytes);
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
  if (is_large(bytes)) {
    unmap_block(block, bytes);
    return;
  }
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
