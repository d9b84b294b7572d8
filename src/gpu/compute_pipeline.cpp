#include "gpu/compute_pipeline.h"

#include <algorithm>
#include <cassert>
#include <string>

namespace maille::gpu {
namespace {

bool is_buffer(VkDescriptorType type) {
  return type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER || type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
}

}  // namespace

Result<ComputePipeline> ComputePipeline::create(const Device& device,
                                                const ComputePipelineInfo& info) {
  ComputePipeline result;
  result.device_ = device.get();
  result.types_.assign(info.bindings.begin(), info.bindings.end());
  const std::string making = "making the " + std::string(info.name) + " pipeline";

  std::vector<VkDescriptorSetLayoutBinding> bindings;
  std::vector<VkDescriptorPoolSize> sizes;
  for (const VkDescriptorType type : info.bindings) {
    bindings.push_back({.binding = static_cast<std::uint32_t>(bindings.size()),
                        .descriptorType = type,
                        .descriptorCount = 1,
                        .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT,
                        .pImmutableSamplers = nullptr});
    sizes.push_back({type, 1});
  }
  VkDescriptorSetLayoutCreateInfo set_info{};
  set_info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
  set_info.bindingCount = static_cast<std::uint32_t>(bindings.size());
  set_info.pBindings = bindings.data();
  VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateDescriptorSetLayout(device.get(), &set_info, nullptr, &set_layout);
      r != VK_SUCCESS) {
    return vk_error(r, making);
  }
  result.set_layout_ = {device.get(), set_layout};
  device.set_name(set_layout, VK_OBJECT_TYPE_DESCRIPTOR_SET_LAYOUT, info.name);

  const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, info.push_constant_bytes};
  VkPipelineLayoutCreateInfo layout_info{};
  layout_info.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
  layout_info.setLayoutCount = 1;
  layout_info.pSetLayouts = &set_layout;
  layout_info.pushConstantRangeCount = info.push_constant_bytes > 0 ? 1 : 0;
  layout_info.pPushConstantRanges = &push;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  if (const VkResult r = vkCreatePipelineLayout(device.get(), &layout_info, nullptr, &layout);
      r != VK_SUCCESS) {
    return vk_error(r, making);
  }
  result.layout_ = {device.get(), layout};
  device.set_name(layout, VK_OBJECT_TYPE_PIPELINE_LAYOUT, info.name);

  VkShaderModuleCreateInfo module_info{};
  module_info.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
  module_info.codeSize = info.spirv.size_bytes();
  module_info.pCode = info.spirv.data();
  VkShaderModule module_handle = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateShaderModule(device.get(), &module_info, nullptr, &module_handle);
      r != VK_SUCCESS) {
    return vk_error(r, making);
  }
  const OwnedShaderModule shader(device.get(), module_handle);
  device.set_name(module_handle, VK_OBJECT_TYPE_SHADER_MODULE, info.name);

  std::vector<VkSpecializationMapEntry> entries;
  for (const Specialization& constant : info.constants) {
    entries.push_back(
        {.constantID = constant.id,
         .offset = static_cast<std::uint32_t>(entries.size() * sizeof(Specialization) +
                                              offsetof(Specialization, value)),
         .size = sizeof constant.value});
  }
  const VkSpecializationInfo specialization{
      .mapEntryCount = static_cast<std::uint32_t>(entries.size()),
      .pMapEntries = entries.data(),
      .dataSize = info.constants.size_bytes(),
      .pData = info.constants.data()};
  VkComputePipelineCreateInfo pipeline_info{};
  pipeline_info.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
  pipeline_info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  pipeline_info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  pipeline_info.stage.module = shader.get();
  pipeline_info.stage.pName = "main";
  pipeline_info.stage.pSpecializationInfo = &specialization;
  pipeline_info.layout = layout;
  VkPipeline pipeline = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateComputePipelines(device.get(), VK_NULL_HANDLE, 1, &pipeline_info,
                                                  nullptr, &pipeline);
      r != VK_SUCCESS) {
    return vk_error(r, making);
  }
  result.pipeline_ = {device.get(), pipeline};
  device.set_name(pipeline, VK_OBJECT_TYPE_PIPELINE, info.name);

  VkDescriptorPoolCreateInfo pool_info{};
  pool_info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
  pool_info.maxSets = 1;
  pool_info.poolSizeCount = static_cast<std::uint32_t>(sizes.size());
  pool_info.pPoolSizes = sizes.data();
  VkDescriptorPool pool = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateDescriptorPool(device.get(), &pool_info, nullptr, &pool);
      r != VK_SUCCESS) {
    return vk_error(r, making);
  }
  result.pool_ = {device.get(), pool};
  device.set_name(pool, VK_OBJECT_TYPE_DESCRIPTOR_POOL, info.name);
  const VkDescriptorSetAllocateInfo allocate_info{
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
      .pNext = nullptr,
      .descriptorPool = pool,
      .descriptorSetCount = 1,
      .pSetLayouts = &set_layout};
  if (const VkResult r = vkAllocateDescriptorSets(device.get(), &allocate_info, &result.set_);
      r != VK_SUCCESS) {
    return vk_error(r, making);
  }
  device.set_name(result.set_, VK_OBJECT_TYPE_DESCRIPTOR_SET, info.name);
  return result;
}

void ComputePipeline::write_bindings(std::span<const Binding> bindings) {
  assert(bindings.size() == types_.size());
  std::vector<VkDescriptorBufferInfo> buffers(bindings.size());
  std::vector<VkDescriptorImageInfo> images(bindings.size());
  std::vector<VkWriteDescriptorSet> writes(bindings.size());
  for (std::size_t i = 0; i < bindings.size(); ++i) {
    buffers[i] = {bindings[i].buffer, 0, VK_WHOLE_SIZE};
    images[i] = {bindings[i].sampler, bindings[i].view, VK_IMAGE_LAYOUT_GENERAL};
    writes[i] = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                 .pNext = nullptr,
                 .dstSet = set_,
                 .dstBinding = static_cast<std::uint32_t>(i),
                 .dstArrayElement = 0,
                 .descriptorCount = 1,
                 .descriptorType = types_[i],
                 .pImageInfo = is_buffer(types_[i]) ? nullptr : &images[i],
                 .pBufferInfo = is_buffer(types_[i]) ? &buffers[i] : nullptr,
                 .pTexelBufferView = nullptr};
  }
  vkUpdateDescriptorSets(device_, static_cast<std::uint32_t>(writes.size()), writes.data(), 0,
                         nullptr);
}

void ComputePipeline::dispatch(VkCommandBuffer commands, std::uint32_t groups_x,
                               std::uint32_t groups_y, std::uint32_t groups_z,
                               std::span<const std::byte> push) const {
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.get(), 0, 1, &set_, 0,
                          nullptr);
  if (!push.empty()) {
    vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0,
                       static_cast<std::uint32_t>(push.size()), push.data());
  }
  vkCmdDispatch(commands, groups_x, groups_y, groups_z);
}

}  // namespace maille::gpu
