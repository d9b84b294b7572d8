// A 3D image with all its memory: one page that is always there.
#pragma once

#include "gpu/image3d.h"
#include "gpu/memory.h"

namespace maille::gpu {

class DenseImage final : public Image3D {
 public:
  static Result<std::unique_ptr<Image3D>> create(WorkQueue& queue, glm::ivec3 extent,
                                                 VkFormat format, std::string_view name);

  // Nothing is ever fresh: the memory came with the image.
  Result<void> commit(const TexelBox&, std::vector<glm::ivec3>&) override { return {}; }
  void release(glm::ivec3) override {}
  Result<void> flush() override { return {}; }
  bool page_committed(glm::ivec3) const override { return true; }
  Footprint footprint() const override { return {1, 1, bytes_}; }

 private:
  OwnedMemory memory_;
  std::uint64_t bytes_ = 0;
};

}  // namespace maille::gpu
