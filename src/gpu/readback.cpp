#include "gpu/readback.h"

namespace maille::gpu {

Result<std::vector<std::byte>> Readback::copy(
    VkDeviceSize bytes, const std::function<void(VkCommandBuffer, VkBuffer)>& record) {
  if (landing_.bytes() < bytes) {
    auto grown = Buffer::create(queue_->device(), bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                MemoryUse::readback, "read-back");
    if (!grown) return grown.error();
    landing_ = std::move(*grown);
  }
  auto done = queue_->run([&](VkCommandBuffer commands) {
    record(commands, landing_.get());
    // Waiting for the timeline does not by itself make the copy visible to the CPU.
    barrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
            VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
  });
  if (!done) return done.error();
  if (auto seen = landing_.invalidate(); !seen) return seen.error();
  const auto mapped = landing_.mapped().first(static_cast<std::size_t>(bytes));
  return std::vector<std::byte>(mapped.begin(), mapped.end());
}

Result<std::vector<std::byte>> Readback::buffer(const Buffer& buffer) {
  return copy(buffer.bytes(), [&](VkCommandBuffer commands, VkBuffer target) {
    const VkBufferCopy region{0, 0, buffer.bytes()};
    vkCmdCopyBuffer(commands, buffer.get(), target, 1, &region);
  });
}

Result<std::vector<std::byte>> Readback::image(const Image2D& image) {
  const VkExtent2D extent = image.extent();
  const VkDeviceSize bytes = VkDeviceSize{extent.width} * extent.height * 4;
  return copy(bytes, [&](VkCommandBuffer commands, VkBuffer target) {
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.imageExtent = {extent.width, extent.height, 1};
    vkCmdCopyImageToBuffer(commands, image.get(), VK_IMAGE_LAYOUT_GENERAL, target, 1, &region);
  });
}

Result<std::vector<std::byte>> Readback::image(const Image3D& image, const TexelBox& box) {
  const glm::ivec3 size = box.size();
  const VkExtent3D extent{static_cast<std::uint32_t>(size.x), static_cast<std::uint32_t>(size.y),
                          static_cast<std::uint32_t>(size.z)};
  const VkDeviceSize bytes =
      VkDeviceSize{extent.width} * extent.height * extent.depth * texel_bytes(image.format());
  return copy(bytes, [&](VkCommandBuffer commands, VkBuffer target) {
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.imageOffset = {box.lo.x, box.lo.y, box.lo.z};
    region.imageExtent = extent;
    vkCmdCopyImageToBuffer(commands, image.get(), VK_IMAGE_LAYOUT_GENERAL, target, 1, &region);
  });
}

}  // namespace maille::gpu
