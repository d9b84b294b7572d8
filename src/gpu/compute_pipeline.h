// A compute shader with one descriptor set, specialised and ready to dispatch.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "gpu/device.h"

namespace maille::gpu {

struct Specialization {
  std::uint32_t id = 0;
  std::uint32_t value = 0;  // a bool is 0 or 1
};

struct ComputePipelineInfo {
  std::span<const std::uint32_t> spirv;
  std::span<const VkDescriptorType> bindings;  // binding number = position
  std::uint32_t push_constant_bytes = 0;       // at most 128, which every device has
  std::span<const Specialization> constants;
  std::string_view name;
};

// What stands behind a binding; layout of images is GENERAL.
struct Binding {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkImageView view = VK_NULL_HANDLE;
  VkSampler sampler = VK_NULL_HANDLE;
};

// The driver compiles at the first dispatch, not here (50 to 140 ms): warm up before measuring.
class ComputePipeline {
 public:
  ComputePipeline() = default;
  static Result<ComputePipeline> create(const Device& device, const ComputePipelineInfo& info);

  // The device must be done with everything that used the old bindings.
  void write_bindings(std::span<const Binding> bindings);
  // push: exactly push_constant_bytes.
  void dispatch(VkCommandBuffer commands, std::uint32_t groups_x, std::uint32_t groups_y,
                std::uint32_t groups_z, std::span<const std::byte> push = {}) const;

  explicit operator bool() const { return static_cast<bool>(pipeline_); }

 private:
  VkDevice device_ = VK_NULL_HANDLE;
  OwnedDescriptorSetLayout set_layout_;
  OwnedPipelineLayout layout_;
  OwnedPipeline pipeline_;
  OwnedDescriptorPool pool_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;  // dies with its pool
  std::vector<VkDescriptorType> types_;
};

}  // namespace maille::gpu
