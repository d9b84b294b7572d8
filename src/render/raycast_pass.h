// One ray a pixel through the volume, into a picture.
#pragma once

#include <map>

#include "gpu/image2d.h"
#include "render/pass_inputs.h"

namespace maille {

// What is compiled into the shader: a mode carries nothing of the others, and without shading no
// gradient is ever taken.
struct RaycastVariant {
  RenderMode mode = RenderMode::composite;
  bool shading = true;
  bool skip_empty = true;
  bool integrated = true;
  auto operator<=>(const RaycastVariant&) const = default;
};

class RaycastPass {
 public:
  // What the pipelines read and write from now on. The device must be done with the old.
  void bind(const PassInputs& inputs, const VolumeTexture& texture, const gpu::Image2D& picture);

  // Makes the variant's pipeline when it is first asked for.
  Result<void> prepare(const gpu::Device& device, const RaycastVariant& variant);
  // The variant must be prepared and the pass bound.
  void record(VkCommandBuffer commands, const RaycastVariant& variant) const;

  int pipelines() const { return static_cast<int>(pipelines_.size()); }

 private:
  std::map<RaycastVariant, gpu::ComputePipeline> pipelines_;
  std::array<gpu::Binding, 5> bindings_{};
  VkExtent2D extent_{};
};

}  // namespace maille
