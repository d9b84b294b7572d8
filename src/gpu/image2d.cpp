#include "gpu/image2d.h"

#include <string>

namespace maille::gpu {

Result<Image2D> Image2D::create(WorkQueue& queue, VkExtent2D extent, std::string_view name,
                                VkFormat format) {
  const Device& device = queue.device();
  const std::uint32_t limit = device.limits().maxImageDimension2D;
  if (extent.width == 0 || extent.height == 0 || extent.width > limit || extent.height > limit) {
    return Error{ErrorKind::device, "a picture of " + std::to_string(extent.width) + "x" +
                                        std::to_string(extent.height) +
                                        " pixels is not one this device makes (1 to " +
                                        std::to_string(limit) + " along a side)"};
  }
  VkImageCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = format;
  info.extent = {extent.width, extent.height, 1};
  info.mipLevels = 1;
  info.arrayLayers = 1;
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.tiling = VK_IMAGE_TILING_OPTIMAL;
  info.usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  if (format == VK_FORMAT_R8G8B8A8_UNORM) info.usage |= VK_IMAGE_USAGE_STORAGE_BIT;
  info.initialLayout = VK_IMAGE_LAYOUT_UNDEFINED;
  const std::string making = "making the " + std::string(name);
  VkImage handle = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateImage(device.get(), &info, nullptr, &handle); r != VK_SUCCESS) {
    return vk_error(r, making);
  }
  Image2D image;
  image.extent_ = extent;
  image.image_ = {device.get(), handle};
  device.set_name(handle, VK_OBJECT_TYPE_IMAGE, name);

  VkMemoryRequirements needs{};
  vkGetImageMemoryRequirements(device.get(), handle, &needs);
  auto memory = allocate(device, needs, MemoryUse::device, name);
  if (!memory) return memory.error();
  image.memory_ = std::move(*memory);
  if (const VkResult r = vkBindImageMemory(device.get(), handle, image.memory_.get(), 0);
      r != VK_SUCCESS) {
    return vk_error(r, making);
  }

  auto moved = queue.run([&](VkCommandBuffer commands) { to_general(commands, handle); });
  if (!moved) return moved.error();
  // The others are copied from and to, and never seen by a shader.
  if (format != VK_FORMAT_R8G8B8A8_UNORM) return image;

  VkImageViewCreateInfo view_info{};
  view_info.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
  view_info.image = handle;
  view_info.viewType = VK_IMAGE_VIEW_TYPE_2D;
  view_info.format = format;
  view_info.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
  VkImageView view = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateImageView(device.get(), &view_info, nullptr, &view);
      r != VK_SUCCESS) {
    return vk_error(r, making);
  }
  image.view_ = {device.get(), view};
  device.set_name(view, VK_OBJECT_TYPE_IMAGE_VIEW, name);
  return image;
}

}  // namespace maille::gpu
