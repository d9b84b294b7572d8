// What one ray hits first. Made with the first pick: a scene without one never has it.
#pragma once

#include <optional>

#include "gpu/readback.h"
#include "render/pass_inputs.h"
#include "render/pick.h"

namespace maille {

class PickPass {
 public:
  static Result<PickPass> create(gpu::WorkQueue& queue);

  // The device must be done with the old.
  void bind(const PassInputs& inputs, const VolumeTexture& texture);

  // After PassInputs::record in the same commands.
  void record(VkCommandBuffer commands, const Ray& ray_voxel) const;
  // What the submission of that found; it must be done.
  Result<std::optional<PickHit>> read(const glm::dmat4& world_from_voxel, TexelScale texel,
                                      const Ray& ray_mm) const;

 private:
  gpu::ComputePipeline pipeline_;
  gpu::Buffer result_;
};

}  // namespace maille
