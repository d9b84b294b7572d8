#include "render/pick_pass.h"

#include <cstring>

#include "shaders/pick.spv.h"

namespace maille {

Result<PickPass> PickPass::create(gpu::WorkQueue& queue) {
  PickPass pass;
  const auto types = PassInputs::types(VK_DESCRIPTOR_TYPE_STORAGE_BUFFER);
  const gpu::Specialization skip_empty{2, 1};
  auto pipeline = gpu::ComputePipeline::create(
      queue.device(), {.spirv = k_pick_spirv,
                       .bindings = types,
                       .push_constant_bytes = sizeof(shader::PickConstants),
                       .constants = {&skip_empty, 1},
                       .name = "pick"});
  if (!pipeline) return pipeline.error();
  pass.pipeline_ = std::move(*pipeline);
  // Written by the shader where the CPU reads it: 32 bytes are not worth a copy.
  auto result = gpu::Buffer::create(queue.device(), sizeof(shader::PickResult),
                                    VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::MemoryUse::readback,
                                    "pick result");
  if (!result) return result.error();
  pass.result_ = std::move(*result);
  return pass;
}

void PickPass::bind(const PassInputs& inputs, const VolumeTexture& texture) {
  pipeline_.write_bindings(inputs.bindings(texture, {.buffer = result_.get()}));
}

void PickPass::record(VkCommandBuffer commands, const Ray& ray_voxel) const {
  const shader::PickConstants push{.origin = glm::vec4(glm::vec3(ray_voxel.origin_mm), 0),
                                   .direction = glm::vec4(glm::vec3(ray_voxel.direction), 0)};
  pipeline_.dispatch(commands, 1, 1, 1, std::as_bytes(std::span(&push, 1)));
  gpu::barrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT,
               VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
}

Result<std::optional<PickHit>> PickPass::read(const glm::dmat4& world_from_voxel, TexelScale texel,
                                              const Ray& ray_mm) const {
  if (auto seen = result_.invalidate(); !seen) return seen.error();
  shader::PickResult found{};
  std::memcpy(&found, result_.mapped().data(), sizeof found);
  if (found.position.w == 0.0f) return std::optional<PickHit>();

  PickHit hit;
  hit.voxel = glm::dvec3(found.position);
  hit.world_mm = transform_point(world_from_voxel, hit.voxel);
  hit.value = static_cast<double>(found.gradient.w) * texel.scale + texel.offset;
  // Gradients go to the world by the inverse transpose.
  const glm::dvec3 gradient =
      glm::transpose(glm::dmat3(glm::inverse(world_from_voxel))) * glm::dvec3(found.gradient);
  const double length = glm::length(gradient);
  if (length > 0.0) {
    hit.normal = gradient / length;
    if (glm::dot(hit.normal, ray_mm.direction) > 0.0) hit.normal = -hit.normal;
  }
  return std::optional(hit);
}

}  // namespace maille
