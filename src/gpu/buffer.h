// A buffer with memory of its own, mapped for its whole life where the CPU touches it.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "gpu/memory.h"

namespace maille::gpu {

class Buffer {
 public:
  Buffer() = default;
  static Result<Buffer> create(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage,
                               MemoryUse use, std::string_view name);

  VkBuffer get() const { return buffer_.get(); }
  VkDeviceSize bytes() const { return bytes_; }
  explicit operator bool() const { return static_cast<bool>(buffer_); }

  // Empty for MemoryUse::device.
  std::span<std::byte> mapped() const { return mapped_; }
  // Readback memory need not be coherent: call before reading what the GPU wrote.
  Result<void> invalidate() const;

 private:
  VkDevice device_ = VK_NULL_HANDLE;
  OwnedMemory memory_;
  OwnedBuffer buffer_;
  VkDeviceSize bytes_ = 0;
  std::span<std::byte> mapped_;
  bool coherent_ = true;
};

}  // namespace maille::gpu
