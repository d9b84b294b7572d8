// Ownership of Vulkan objects, and how a VkResult becomes an Error.
#pragma once

#include <string>
#include <string_view>
#include <utility>

#include <vulkan/vulkan.h>

#include "core/result.h"

namespace maille::gpu {

// A child of a VkDevice that is destroyed with its owner. The GPU must be done with it by then: the
// owner waits (WorkQueue::wait), the handle does not.
template <class Handle, auto destroy>
class Owned {
 public:
  Owned() = default;
  Owned(VkDevice device, Handle handle) : device_(device), handle_(handle) {}
  Owned(Owned&& other) noexcept
      : device_(other.device_), handle_(std::exchange(other.handle_, VK_NULL_HANDLE)) {}
  Owned& operator=(Owned&& other) noexcept {
    if (this != &other) {
      reset();
      device_ = other.device_;
      handle_ = std::exchange(other.handle_, VK_NULL_HANDLE);
    }
    return *this;
  }
  ~Owned() { reset(); }

  void reset() {
    if (handle_ != VK_NULL_HANDLE) destroy(device_, handle_, nullptr);
    handle_ = VK_NULL_HANDLE;
  }

  Handle get() const { return handle_; }
  explicit operator bool() const { return handle_ != VK_NULL_HANDLE; }

 private:
  VkDevice device_ = VK_NULL_HANDLE;
  Handle handle_ = VK_NULL_HANDLE;
};

using OwnedBuffer = Owned<VkBuffer, vkDestroyBuffer>;
using OwnedCommandPool = Owned<VkCommandPool, vkDestroyCommandPool>;
using OwnedDescriptorPool = Owned<VkDescriptorPool, vkDestroyDescriptorPool>;
using OwnedDescriptorSetLayout = Owned<VkDescriptorSetLayout, vkDestroyDescriptorSetLayout>;
using OwnedFramebuffer = Owned<VkFramebuffer, vkDestroyFramebuffer>;
using OwnedImage = Owned<VkImage, vkDestroyImage>;
using OwnedImageView = Owned<VkImageView, vkDestroyImageView>;
using OwnedMemory = Owned<VkDeviceMemory, vkFreeMemory>;
using OwnedPipeline = Owned<VkPipeline, vkDestroyPipeline>;
using OwnedPipelineLayout = Owned<VkPipelineLayout, vkDestroyPipelineLayout>;
using OwnedQueryPool = Owned<VkQueryPool, vkDestroyQueryPool>;
using OwnedRenderPass = Owned<VkRenderPass, vkDestroyRenderPass>;
using OwnedSampler = Owned<VkSampler, vkDestroySampler>;
using OwnedSemaphore = Owned<VkSemaphore, vkDestroySemaphore>;
using OwnedShaderModule = Owned<VkShaderModule, vkDestroyShaderModule>;
using OwnedSwapchain = Owned<VkSwapchainKHR, vkDestroySwapchainKHR>;

// doing completes "while …": vk_error(r, "allocating 64 MiB for volume pages").
// Kinds: out_of_memory for the results that say so, device for every other one (lost included).
Error vk_error(VkResult result, std::string_view doing);
std::string_view name_of(VkResult result);

}  // namespace maille::gpu
