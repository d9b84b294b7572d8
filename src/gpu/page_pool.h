// Device memory in pages of one size, cut from blocks of 64 MiB.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gpu/memory.h"

namespace maille::gpu {

struct Page {
  std::uint32_t block = 0;
  std::uint32_t number = 0;  // within the block
};

class PagePool {
 public:
  // needs: of the sparse image. Its alignment is the size of a page, and a multiple of 64 KiB:
  // nothing reports a bind at another offset.
  PagePool(const Device& device, const VkMemoryRequirements& needs, std::string name);

  Result<Page> take();
  void give(Page page) { free_.push_back(page); }

  VkDeviceMemory memory(Page page) const { return blocks_[page.block].get(); }
  VkDeviceSize offset(Page page) const { return page.number * page_bytes_; }
  VkDeviceSize page_bytes() const { return page_bytes_; }
  std::uint64_t bytes() const { return blocks_.size() * pages_a_block_ * page_bytes_; }

 private:
  const Device* device_;
  VkMemoryRequirements needs_;
  VkDeviceSize page_bytes_;
  std::uint32_t pages_a_block_;
  std::string name_;
  std::vector<OwnedMemory> blocks_;
  std::vector<Page> free_;  // last in, first out: blocks stay dense
};

}  // namespace maille::gpu
