#include "gpu/page_pool.h"

#include <algorithm>
#include <cassert>

namespace maille::gpu {
namespace {

// Large enough that a volume takes a few dozen allocations (a device may allow only 4096), small
// enough that a small volume does not hold much for nothing.
constexpr VkDeviceSize kBlockBytes = VkDeviceSize{64} << 20;

}  // namespace

PagePool::PagePool(const Device& device, const VkMemoryRequirements& needs, std::string name)
    : device_(&device),
      needs_(needs),
      page_bytes_(needs.alignment),
      pages_a_block_(static_cast<std::uint32_t>(std::clamp<VkDeviceSize>(
          needs.size / needs.alignment, 1, kBlockBytes / needs.alignment))),
      name_(std::move(name)) {
  assert(page_bytes_ % (64 << 10) == 0);
}

Result<Page> PagePool::take() {
  if (free_.empty()) {
    VkMemoryRequirements block = needs_;
    block.size = pages_a_block_ * page_bytes_;
    auto memory = allocate(*device_, block, MemoryUse::device, name_ + " pages");
    if (!memory) return memory.error();
    blocks_.push_back(std::move(*memory));
    for (std::uint32_t number = pages_a_block_; number-- > 0;) {
      free_.push_back({static_cast<std::uint32_t>(blocks_.size() - 1), number});
    }
  }
  const Page page = free_.back();
  free_.pop_back();
  return page;
}

}  // namespace maille::gpu
