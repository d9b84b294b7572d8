// A picture: RGBA8, in layout GENERAL for its whole life.
#pragma once

#include <string_view>

#include "gpu/memory.h"
#include "gpu/work_queue.h"

namespace maille::gpu {

class Image2D {
 public:
  Image2D() = default;
  // UNORM: compute shaders write it. SRGB: a copy of one, for targets that convert. Both are
  // transfer sources and destinations. Errors: device (too large for it), out_of_memory.
  static Result<Image2D> create(WorkQueue& queue, VkExtent2D extent, std::string_view name,
                                VkFormat format = VK_FORMAT_R8G8B8A8_UNORM);

  VkImage get() const { return image_.get(); }
  VkImageView view() const { return view_.get(); }
  VkExtent2D extent() const { return extent_; }
  explicit operator bool() const { return static_cast<bool>(image_); }

 private:
  OwnedMemory memory_;
  OwnedImage image_;
  OwnedImageView view_;
  VkExtent2D extent_{};
};

}  // namespace maille::gpu
