#include "gpu/memory.h"

#include <array>
#include <optional>
#include <string>

namespace maille::gpu {
namespace {

struct Wish {
  VkMemoryPropertyFlags must;
  VkMemoryPropertyFlags better;  // in addition, where there is one
  VkMemoryPropertyFlags worse;   // avoided, where there is one without
};

Wish wish_for(MemoryUse use) {
  constexpr VkMemoryPropertyFlags visible = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
  constexpr VkMemoryPropertyFlags coherent = VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  constexpr VkMemoryPropertyFlags cached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  constexpr VkMemoryPropertyFlags local = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  switch (use) {
    case MemoryUse::device: return {0, local, visible};
    case MemoryUse::upload: return {visible | coherent, 0, cached};
    // Not device-local: the visible part of a GPU's own memory is small and slow to read.
    case MemoryUse::staging: return {visible | coherent, cached, local};
    case MemoryUse::readback: break;
  }
  return {visible, cached, local};
}

}  // namespace

Result<std::uint32_t> memory_type_for(const Device& device, std::uint32_t type_bits,
                                      MemoryUse use) {
  const Wish wish = wish_for(use);
  const VkPhysicalDeviceMemoryProperties& memory = device.memory();
  std::optional<std::uint32_t> best;
  int best_score = -1;
  for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
    const VkMemoryPropertyFlags flags = memory.memoryTypes[i].propertyFlags;
    // Memory that only lazy attachments, protected or vendor-coherent access can use.
    constexpr VkMemoryPropertyFlags plain =
        VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT |
        VK_MEMORY_PROPERTY_HOST_COHERENT_BIT | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
    if ((type_bits & (1u << i)) == 0 || (flags & wish.must) != wish.must || (flags & ~plain) != 0) {
      continue;
    }
    const int score =
        ((flags & wish.better) == wish.better ? 2 : 0) + ((flags & wish.worse) == 0 ? 1 : 0);
    if (score > best_score) {
      best = i;
      best_score = score;
    }
  }
  if (!best) return Error{ErrorKind::device, "Vulkan: no memory of the kind that is needed"};
  return *best;
}

Result<OwnedMemory> allocate(const Device& device, const VkMemoryRequirements& needs, MemoryUse use,
                             std::string_view what) {
  auto type = memory_type_for(device, needs.memoryTypeBits, use);
  if (!type) return type.error();
  const VkMemoryAllocateInfo info{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                  .pNext = nullptr,
                                  .allocationSize = needs.size,
                                  .memoryTypeIndex = *type};
  VkDeviceMemory memory = VK_NULL_HANDLE;
  if (const VkResult r = vkAllocateMemory(device.get(), &info, nullptr, &memory); r != VK_SUCCESS) {
    return vk_error(r, "allocating " + std::to_string((needs.size + (1u << 20) - 1) >> 20) +
                           " MiB for the " + std::string(what));
  }
  device.set_name(memory, VK_OBJECT_TYPE_DEVICE_MEMORY, what);
  return OwnedMemory(device.get(), memory);
}

}  // namespace maille::gpu
