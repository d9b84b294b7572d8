// What every pass over the volume reads: constants, skip grid, transfer table, sampler.
#pragma once

#include <array>

#include "gpu/buffer.h"
#include "gpu/compute_pipeline.h"
#include "gpu/work_queue.h"
#include "render/camera.h"
#include "render/volume_texture.h"
#include "shared/pass_constants.h"

namespace maille {

// Bindings 0..3 of shaders/volume.glsl; a pass adds its own as number 4.
class PassInputs {
 public:
  static Result<PassInputs> create(gpu::WorkQueue& queue);

  // Room for the skip grid of this texture. The device must be done with the old one.
  Result<void> fit(const VolumeTexture& texture);

  // Records what has changed since the last time, before a dispatch of the same command buffer.
  // May wait for the copy of the skip grid before. table: at most 3 k_transfer_entries.
  Result<void> record(VkCommandBuffer commands, const VolumeTexture& texture,
                      const shader::PassConstants& constants, std::span<const glm::vec4> table);
  // The value of the submission that holds what was recorded.
  void submitted(std::uint64_t value);

  std::array<gpu::Binding, 5> bindings(const VolumeTexture& texture, gpu::Binding own) const;
  static std::array<VkDescriptorType, 5> types(VkDescriptorType own);
  std::uint64_t gpu_bytes() const;

 private:
  gpu::WorkQueue* queue_ = nullptr;
  gpu::Buffer constants_;
  gpu::Buffer table_;
  gpu::Buffer skip_;
  gpu::Buffer skip_upload_;
  gpu::OwnedSampler sampler_;
  std::vector<glm::vec4> table_there_;  // what the device's copy holds
  std::uint64_t skip_there_ = 0;        // VolumeTexture::skip_version + 1; 0: nothing
  std::uint64_t skip_busy_until_ = 0;   // the upload buffer is being copied until then
  bool skip_recorded_ = false;
};

// Everything in PassConstants but what depends on the transfer function's table.
struct ViewDescription {
  RayFan fan;
  glm::dmat4 world_from_voxel;
  double step_voxels;
  double iso_value;
  glm::dvec3 background;
};
shader::PassConstants pass_constants(const ViewDescription& view, const VolumeTexture& texture,
                                     const TransferFunction& transfer);

}  // namespace maille
