#include "render/raycast_pass.h"

#include "shaders/raycast.spv.h"

namespace maille {
namespace {

int mode_number(RenderMode mode) {
  switch (mode) {
    case RenderMode::composite: return shader::k_mode_composite;
    case RenderMode::iso: return shader::k_mode_iso;
    case RenderMode::composite_with_iso: return shader::k_mode_composite_with_iso;
    case RenderMode::mip: return shader::k_mode_mip;
    case RenderMode::average: break;
  }
  return shader::k_mode_average;
}

}  // namespace

void RaycastPass::bind(const PassInputs& inputs, const VolumeTexture& texture,
                       const gpu::Image2D& picture) {
  bindings_ = inputs.bindings(texture, {.view = picture.view()});
  extent_ = picture.extent();
  for (auto& [variant, pipeline] : pipelines_) pipeline.write_bindings(bindings_);
}

Result<void> RaycastPass::prepare(const gpu::Device& device, const RaycastVariant& variant) {
  if (pipelines_.contains(variant)) return {};
  const std::array<gpu::Specialization, 4> constants{
      {{0, static_cast<std::uint32_t>(mode_number(variant.mode))},
       {1, variant.shading ? 1u : 0u},
       {2, variant.skip_empty ? 1u : 0u},
       {3, variant.integrated ? 1u : 0u}}};
  const auto types = PassInputs::types(VK_DESCRIPTOR_TYPE_STORAGE_IMAGE);
  auto pipeline = gpu::ComputePipeline::create(device, {.spirv = k_raycast_spirv,
                                                        .bindings = types,
                                                        .push_constant_bytes = 0,
                                                        .constants = constants,
                                                        .name = "raycast"});
  if (!pipeline) return pipeline.error();
  pipeline->write_bindings(bindings_);
  pipelines_.emplace(variant, std::move(*pipeline));
  return {};
}

void RaycastPass::record(VkCommandBuffer commands, const RaycastVariant& variant) const {
  constexpr std::uint32_t edge = shader::k_group_edge;
  pipelines_.at(variant).dispatch(commands, (extent_.width + edge - 1) / edge,
                                  (extent_.height + edge - 1) / edge, 1);
}

}  // namespace maille
