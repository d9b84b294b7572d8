#include "render/pass_inputs.h"

#include <cstring>

namespace maille {
namespace {

constexpr VkPipelineStageFlags kCompute = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
constexpr VkPipelineStageFlags kTransfer = VK_PIPELINE_STAGE_TRANSFER_BIT;

glm::vec4 diagonal(const glm::dmat3& m) {
  return {static_cast<float>(m[0][0]), static_cast<float>(m[1][1]), static_cast<float>(m[2][2]), 0};
}

glm::vec4 mixed(const glm::dmat3& m) {
  return {static_cast<float>(m[2][1]), static_cast<float>(m[0][2]), static_cast<float>(m[1][0]), 0};
}

}  // namespace

Result<PassInputs> PassInputs::create(gpu::WorkQueue& queue) {
  const gpu::Device& device = queue.device();
  PassInputs inputs;
  inputs.queue_ = &queue;
  auto constants =
      gpu::Buffer::create(device, sizeof(shader::PassConstants),
                          VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                          gpu::MemoryUse::device, "pass constants");
  if (!constants) return constants.error();
  inputs.constants_ = std::move(*constants);
  auto table =
      gpu::Buffer::create(device, 3 * shader::k_transfer_entries * sizeof(glm::vec4),
                          VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                          gpu::MemoryUse::device, "transfer table");
  if (!table) return table.error();
  inputs.table_ = std::move(*table);

  VkSamplerCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO;
  info.magFilter = VK_FILTER_LINEAR;
  info.minFilter = VK_FILTER_LINEAR;
  info.mipmapMode = VK_SAMPLER_MIPMAP_MODE_NEAREST;
  info.addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  info.addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  info.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  VkSampler sampler = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateSampler(device.get(), &info, nullptr, &sampler); r != VK_SUCCESS) {
    return gpu::vk_error(r, "making the volume's sampler");
  }
  inputs.sampler_ = {device.get(), sampler};
  device.set_name(sampler, VK_OBJECT_TYPE_SAMPLER, "volume");
  return inputs;
}

Result<void> PassInputs::fit(const VolumeTexture& texture) {
  const gpu::Device& device = queue_->device();
  const std::size_t bytes = texture.skip_grid().distances().size();
  if (bytes > device.limits().maxStorageBufferRange) {
    return Error{ErrorKind::out_of_memory, "the volume has more blocks than device '" +
                                               device.info().name + "' takes in one buffer"};
  }
  auto skip = gpu::Buffer::create(
      device, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
      gpu::MemoryUse::device, "skip grid");
  if (!skip) return skip.error();
  auto upload = gpu::Buffer::create(device, bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                                    gpu::MemoryUse::upload, "skip grid, upload");
  if (!upload) return upload.error();
  skip_ = std::move(*skip);
  skip_upload_ = std::move(*upload);
  skip_there_ = 0;
  return {};
}

Result<void> PassInputs::record(VkCommandBuffer commands, const VolumeTexture& texture,
                                const shader::PassConstants& constants,
                                std::span<const glm::vec4> table) {
  vkCmdUpdateBuffer(commands, constants_.get(), 0, sizeof constants, &constants);
  if (!std::equal(table.begin(), table.end(), table_there_.begin(), table_there_.end())) {
    vkCmdUpdateBuffer(commands, table_.get(), 0, table.size_bytes(), table.data());
    table_there_.assign(table.begin(), table.end());
  }
  if (skip_there_ != texture.skip_version() + 1) {
    if (auto free = queue_->wait(skip_busy_until_); !free) return free.error();
    const auto distances = texture.skip_grid().distances();
    std::memcpy(skip_upload_.mapped().data(), distances.data(), distances.size());
    const VkBufferCopy all{0, 0, distances.size()};
    vkCmdCopyBuffer(commands, skip_upload_.get(), skip_.get(), 1, &all);
    skip_there_ = texture.skip_version() + 1;
    skip_recorded_ = true;
  }
  gpu::barrier(commands, kTransfer, VK_ACCESS_TRANSFER_WRITE_BIT, kCompute,
               VK_ACCESS_UNIFORM_READ_BIT | VK_ACCESS_SHADER_READ_BIT);
  return {};
}

void PassInputs::submitted(std::uint64_t value) {
  if (skip_recorded_) skip_busy_until_ = value;
  skip_recorded_ = false;
}

std::array<gpu::Binding, 5> PassInputs::bindings(const VolumeTexture& texture,
                                                 gpu::Binding own) const {
  return {gpu::Binding{.buffer = constants_.get()},
          gpu::Binding{.view = texture.image().view(), .sampler = sampler_.get()},
          gpu::Binding{.buffer = skip_.get()}, gpu::Binding{.buffer = table_.get()}, own};
}

std::array<VkDescriptorType, 5> PassInputs::types(VkDescriptorType own) {
  return {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
          VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, own};
}

std::uint64_t PassInputs::gpu_bytes() const {
  return constants_.bytes() + table_.bytes() + skip_.bytes() + skip_upload_.bytes();
}

shader::PassConstants pass_constants(const ViewDescription& view, const VolumeTexture& texture,
                                     const TransferFunction& transfer) {
  const glm::dmat4 voxel_from_world = glm::inverse(view.world_from_voxel);
  const glm::dmat3 linear(view.world_from_voxel);
  const glm::dmat3 inverse(voxel_from_world);
  const glm::dmat3 length = glm::transpose(linear) * linear;
  const glm::dmat3 gradient = inverse * glm::transpose(inverse);
  const auto point = [&](glm::dvec3 p) { return glm::vec3(transform_point(voxel_from_world, p)); };
  const auto vector = [&](glm::dvec3 v) {
    return glm::vec4(glm::vec3(transform_vector(voxel_from_world, v)), 0);
  };
  const TexelScale texel = texture.texel_scale();
  const double lowest = (transfer.lowest() - texel.offset) / texel.scale;
  const double range = (transfer.highest() - transfer.lowest()) / texel.scale;
  const double flat = shader::k_flat_gradient * range;

  shader::PassConstants constants{};
  constants.volume_size = glm::ivec4(texture.grid().volume_size(), 0);
  constants.texture_from_voxel = glm::vec4(1.0 / glm::dvec3(texture.grid().volume_size()), 0.0);
  constants.block_count = glm::ivec4(texture.blocks(), texture.halo_blocks());
  constants.eye = glm::vec4(point(view.fan.eye_mm), static_cast<float>(view.step_voxels));
  constants.corner = vector(view.fan.corner);
  constants.across = vector(view.fan.across);
  constants.along = vector(view.fan.along);
  constants.length_diagonal = diagonal(length);
  constants.length_mixed = mixed(length);
  constants.gradient_diagonal = diagonal(gradient);
  constants.gradient_mixed = mixed(gradient);
  constants.background =
      glm::vec4(glm::vec3(view.background),
                static_cast<float>((view.iso_value - texel.offset) / texel.scale));
  constants.transfer = {
      static_cast<float>(lowest),
      range > 0.0 ? static_cast<float>((shader::k_transfer_entries - 1) / range) : 0.0f,
      static_cast<float>(flat * flat), 0.0f};
  return constants;
}

}  // namespace maille
