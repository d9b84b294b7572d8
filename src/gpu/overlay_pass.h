// What is drawn over a picture in the window: a render pass that keeps what the blit left.
#pragma once

#include <functional>

#include "gpu/work_queue.h"

namespace maille::gpu {

// What Dear ImGui's Vulkan back-end wants to be told (ImGui_ImplVulkan_InitInfo, field by field).
// Stays valid while the swapchain lives, however often the window is resized.
struct OverlayTarget {
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  std::uint32_t queue_family = 0;
  VkDescriptorPool descriptor_pool = VK_NULL_HANDLE;
  VkRenderPass render_pass = VK_NULL_HANDLE;
  std::uint32_t min_image_count = 2;
  std::uint32_t image_count = 2;
};

// Records draw calls within OverlayTarget::render_pass over the whole window.
using DrawOverlay = std::function<void(VkCommandBuffer commands)>;

class OverlayPass {
 public:
  OverlayPass() = default;
  static Result<OverlayPass> create(const WorkQueue& queue, VkFormat format);

  // Wants the image in COLOR_ATTACHMENT_OPTIMAL, leaves it ready to present.
  VkRenderPass render_pass() const { return render_pass_.get(); }
  OverlayTarget target(std::uint32_t image_count) const;

 private:
  const Device* device_ = nullptr;
  OwnedRenderPass render_pass_;
  OwnedDescriptorPool descriptors_;
};

}  // namespace maille::gpu
