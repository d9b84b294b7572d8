// From the device back to the CPU. Each call waits for everything submitted before it.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "gpu/buffer.h"
#include "gpu/image2d.h"
#include "gpu/image3d.h"

namespace maille::gpu {

class Readback {
 public:
  explicit Readback(WorkQueue& queue) : queue_(&queue) {}

  // Tightly packed, x fastest. The buffer must be a transfer source.
  Result<std::vector<std::byte>> buffer(const Buffer& buffer);
  Result<std::vector<std::byte>> image(const Image2D& image);
  // Undefined where the box touches pages without memory.
  Result<std::vector<std::byte>> image(const Image3D& image, const TexelBox& box);

 private:
  Result<std::vector<std::byte>> copy(VkDeviceSize bytes,
                                      const std::function<void(VkCommandBuffer, VkBuffer)>& record);
  WorkQueue* queue_;
  Buffer landing_;  // kept between calls, grown when too small
};

}  // namespace maille::gpu
