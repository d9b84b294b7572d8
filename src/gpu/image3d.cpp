#include "gpu/image3d.h"

#include <string>

#include "gpu/dense_image.h"
#include "gpu/sparse_image.h"

namespace maille::gpu {

std::size_t texel_bytes(VkFormat format) {
  switch (format) {
    case VK_FORMAT_R8_UNORM: return 1;
    case VK_FORMAT_R16_UNORM: return 2;
    default: return 4;
  }
}

bool Image3D::committed(const TexelBox& box) const {
  const TexelBox inside{glm::max(box.lo, glm::ivec3(0)), glm::min(box.hi, extent_)};
  if (inside.lo != box.lo || inside.hi != box.hi) return false;
  const TexelBox touched = pages_touching(box);
  for (int z = touched.lo.z; z < touched.hi.z; ++z) {
    for (int y = touched.lo.y; y < touched.hi.y; ++y) {
      for (int x = touched.lo.x; x < touched.hi.x; ++x) {
        if (!page_committed({x, y, z})) return false;
      }
    }
  }
  return true;
}

Result<void> Image3D::make_image(const Device& device, glm::ivec3 extent, VkFormat format,
                                 bool sparse, std::string_view name) {
  VkImageCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
  if (sparse)
    info.flags = VK_IMAGE_CREATE_SPARSE_BINDING_BIT | VK_IMAGE_CREATE_SPARSE_RESIDENCY_BIT;
  info.imageType = VK_IMAGE_TYPE_3D;
  info.format = format;
  info.extent = {static_cast<std::uint32_t>(extent.x), static_cast<std::uint32_t>(extent.y),
                 static_cast<std::uint32_t>(extent.z)};
  info.mipLevels = 1;
  info.arrayLayers = 1;
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.tiling = VK_IMAGE_TILING_OPTIMAL;
  info.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT |
               VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  info.initialLayout = VK_IMAGE_LAYOUT_UNDEFINED;

  const std::string of_size = std::to_string(extent.x) + "x" + std::to_string(extent.y) + "x" +
                              std::to_string(extent.z) + " texels";
  VkFormatProperties features{};
  vkGetPhysicalDeviceFormatProperties(device.physical(), format, &features);
  if ((features.optimalTilingFeatures & VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT) == 0) {
    return Error{ErrorKind::device, "device '" + device.info().name +
                                        "' does not filter 3D textures of " +
                                        std::to_string(8 * texel_bytes(format)) + "-bit samples"};
  }
  VkImageFormatProperties limits{};
  const VkResult supported = vkGetPhysicalDeviceImageFormatProperties(
      device.physical(), format, info.imageType, info.tiling, info.usage, info.flags, &limits);
  if (supported != VK_SUCCESS || info.extent.width > limits.maxExtent.width ||
      info.extent.height > limits.maxExtent.height || info.extent.depth > limits.maxExtent.depth) {
    return Error{
        ErrorKind::device,
        "device '" + device.info().name + "' makes no 3D texture of " + of_size +
            (supported == VK_SUCCESS
                 ? " (at most " + std::to_string(limits.maxExtent.width) + " along an axis)"
                 : "")};
  }

  const std::uint64_t bytes = std::uint64_t{info.extent.width} * info.extent.height *
                              info.extent.depth * texel_bytes(format);
  if (bytes > limits.maxResourceSize) {
    return too_large_for_one_piece(device, bytes, limits.maxResourceSize, "");
  }

  VkImage handle = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateImage(device.get(), &info, nullptr, &handle); r != VK_SUCCESS) {
    return vk_error(r, "making a 3D texture of " + of_size);
  }
  image_ = {device.get(), handle};
  device.set_name(handle, VK_OBJECT_TYPE_IMAGE, name);
  extent_ = extent;
  format_ = format;
  return {};
}

Result<void> Image3D::make_view(const Device& device, std::string_view name) {
  VkImageViewCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
  info.image = image_.get();
  info.viewType = VK_IMAGE_VIEW_TYPE_3D;
  info.format = format_;
  info.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
  VkImageView view = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateImageView(device.get(), &info, nullptr, &view); r != VK_SUCCESS) {
    return vk_error(r, "making the view of a 3D texture");
  }
  view_ = {device.get(), view};
  device.set_name(view, VK_OBJECT_TYPE_IMAGE_VIEW, name);
  return {};
}

Error too_large_for_one_piece(const Device& device, std::uint64_t bytes, std::uint64_t limit,
                              std::string_view remedy) {
  return {ErrorKind::out_of_memory, "the volume takes " + std::to_string(bytes >> 20) +
                                        " MiB as a 3D texture; device '" + device.info().name +
                                        "' allows " + std::to_string(limit >> 20) + " MiB" +
                                        std::string(remedy)};
}

Result<std::unique_ptr<Image3D>> make_image3d(WorkQueue& queue, glm::ivec3 extent, VkFormat format,
                                              std::string_view name) {
  return queue.device().sparse_store() ? SparseImage::create(queue, extent, format, name)
                                       : DenseImage::create(queue, extent, format, name);
}

}  // namespace maille::gpu
