#include "gpu/buffer.h"

#include <string>

namespace maille::gpu {

Result<Buffer> Buffer::create(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage,
                              MemoryUse use, std::string_view name) {
  const VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                .pNext = nullptr,
                                .flags = 0,
                                .size = bytes,
                                .usage = usage,
                                .sharingMode = VK_SHARING_MODE_EXCLUSIVE,
                                .queueFamilyIndexCount = 0,
                                .pQueueFamilyIndices = nullptr};
  VkBuffer handle = VK_NULL_HANDLE;
  const std::string making = "making the " + std::string(name);
  if (const VkResult r = vkCreateBuffer(device.get(), &info, nullptr, &handle); r != VK_SUCCESS) {
    return vk_error(r, making);
  }
  Buffer buffer;
  buffer.device_ = device.get();
  buffer.bytes_ = bytes;
  buffer.buffer_ = {device.get(), handle};
  device.set_name(handle, VK_OBJECT_TYPE_BUFFER, name);

  VkMemoryRequirements needs{};
  vkGetBufferMemoryRequirements(device.get(), handle, &needs);
  auto memory = allocate(device, needs, use, name);
  if (!memory) return memory.error();
  buffer.memory_ = std::move(*memory);
  if (const VkResult r = vkBindBufferMemory(device.get(), handle, buffer.memory_.get(), 0);
      r != VK_SUCCESS) {
    return vk_error(r, making);
  }
  if (use != MemoryUse::device) {
    void* data = nullptr;
    if (const VkResult r =
            vkMapMemory(device.get(), buffer.memory_.get(), 0, VK_WHOLE_SIZE, 0, &data);
        r != VK_SUCCESS) {
      return vk_error(r, "mapping the " + std::string(name));
    }
    buffer.mapped_ = {static_cast<std::byte*>(data), static_cast<std::size_t>(bytes)};
    const auto type = memory_type_for(device, needs.memoryTypeBits, use);
    buffer.coherent_ = (device.memory().memoryTypes[*type].propertyFlags &
                        VK_MEMORY_PROPERTY_HOST_COHERENT_BIT) != 0;
  }
  return buffer;
}

Result<void> Buffer::invalidate() const {
  if (coherent_) return {};
  const VkMappedMemoryRange range{.sType = VK_STRUCTURE_TYPE_MAPPED_MEMORY_RANGE,
                                  .pNext = nullptr,
                                  .memory = memory_.get(),
                                  .offset = 0,
                                  .size = VK_WHOLE_SIZE};
  if (const VkResult r = vkInvalidateMappedMemoryRanges(device_, 1, &range); r != VK_SUCCESS) {
    return vk_error(r, "reading back");
  }
  return {};
}

}  // namespace maille::gpu
