#include "gpu/dense_image.h"

namespace maille::gpu {

Result<std::unique_ptr<Image3D>> DenseImage::create(WorkQueue& queue, glm::ivec3 extent,
                                                    VkFormat format, std::string_view name) {
  const Device& device = queue.device();
  auto image = std::make_unique<DenseImage>();
  if (auto made = image->make_image(device, extent, format, false, name); !made) {
    return made.error();
  }
  image->page_texels_ = extent;

  VkMemoryRequirements needs{};
  vkGetImageMemoryRequirements(device.get(), image->get(), &needs);
  VkPhysicalDeviceVulkan11Properties limits{};
  limits.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES;
  VkPhysicalDeviceProperties2 properties{};
  properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
  properties.pNext = &limits;
  vkGetPhysicalDeviceProperties2(device.physical(), &properties);
  const char* remedy = device.info().sparse ? " in one piece; the sparse volume store needs no "
                                              "single piece and leaves out what is not visible"
                                            : " in one piece";
  if (needs.size > limits.maxMemoryAllocationSize) {
    return too_large_for_one_piece(device, needs.size, limits.maxMemoryAllocationSize, remedy);
  }
  auto memory = allocate(device, needs, MemoryUse::device, name);
  if (!memory) return memory.error();
  image->memory_ = std::move(*memory);
  image->bytes_ = needs.size;
  // Some drivers say only here that an image is too large.
  if (const VkResult r = vkBindImageMemory(device.get(), image->get(), image->memory_.get(), 0);
      r != VK_SUCCESS) {
    return too_large_for_one_piece(device, needs.size, limits.maxMemoryAllocationSize, remedy);
  }
  if (auto made = image->make_view(device, name); !made) return made.error();

  // Zeros, so that a picture taken before every brick is there is the same every time.
  auto cleared = queue.run([&](VkCommandBuffer commands) {
    to_general(commands, image->get());
    const VkClearColorValue zero{};
    const VkImageSubresourceRange all{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    vkCmdClearColorImage(commands, image->get(), VK_IMAGE_LAYOUT_GENERAL, &zero, 1, &all);
  });
  if (!cleared) return cleared.error();
  return std::unique_ptr<Image3D>(std::move(image));
}

}  // namespace maille::gpu
