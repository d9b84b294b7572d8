#include "gpu/overlay_pass.h"

#include <algorithm>

namespace maille::gpu {

Result<OverlayPass> OverlayPass::create(const WorkQueue& queue, VkFormat format) {
  const Device& device = queue.device();
  OverlayPass result;
  result.device_ = &device;
  const VkAttachmentDescription attachment{
      .flags = 0,
      .format = format,
      .samples = VK_SAMPLE_COUNT_1_BIT,
      .loadOp = VK_ATTACHMENT_LOAD_OP_LOAD,
      .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
      .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
      .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
      .initialLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
      .finalLayout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR};
  const VkAttachmentReference reference{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
  VkSubpassDescription subpass{};
  subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
  subpass.colorAttachmentCount = 1;
  subpass.pColorAttachments = &reference;
  const VkSubpassDependency before{
      .srcSubpass = VK_SUBPASS_EXTERNAL,
      .dstSubpass = 0,
      .srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
      .dstStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
      .srcAccessMask = 0,
      .dstAccessMask = VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
      .dependencyFlags = 0};
  VkRenderPassCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO;
  info.attachmentCount = 1;
  info.pAttachments = &attachment;
  info.subpassCount = 1;
  info.pSubpasses = &subpass;
  info.dependencyCount = 1;
  info.pDependencies = &before;
  VkRenderPass pass = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateRenderPass(device.get(), &info, nullptr, &pass); r != VK_SUCCESS) {
    return vk_error(r, "making the overlay's render pass");
  }
  result.render_pass_ = {device.get(), pass};
  device.set_name(pass, VK_OBJECT_TYPE_RENDER_PASS, "overlay");

  const VkDescriptorPoolSize fonts{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 16};
  const VkDescriptorPoolCreateInfo pool_info{
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
      .pNext = nullptr,
      .flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT,
      .maxSets = 16,
      .poolSizeCount = 1,
      .pPoolSizes = &fonts};
  VkDescriptorPool pool = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateDescriptorPool(device.get(), &pool_info, nullptr, &pool);
      r != VK_SUCCESS) {
    return vk_error(r, "making the overlay's descriptors");
  }
  result.descriptors_ = {device.get(), pool};
  device.set_name(pool, VK_OBJECT_TYPE_DESCRIPTOR_POOL, "overlay");
  return result;
}

OverlayTarget OverlayPass::target(std::uint32_t image_count) const {
  const Device& device = *device_;
  return {.instance = device.instance().get(),
          .physical = device.physical(),
          .device = device.get(),
          .queue = device.general().handle,
          .queue_family = device.general().family,
          .descriptor_pool = descriptors_.get(),
          .render_pass = render_pass_.get(),
          .min_image_count = 2,
          .image_count = std::max(2u, image_count)};
}

}  // namespace maille::gpu
