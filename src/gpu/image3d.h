// Where a 3D texture keeps its texels: one interface, two rooms behind it.
//
//   DenseImage   all memory at once; copies into it are cheap everywhere
//   SparseImage  memory page by page, only where asked for
//
// Layout GENERAL for its whole life. Calls come from one thread. Contents of a page are undefined
// until written, after every bind anew: whoever commits a box uploads it.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "gpu/work_queue.h"

namespace maille::gpu {

// Half-open box of texels.
struct TexelBox {
  glm::ivec3 lo{0};
  glm::ivec3 hi{0};

  glm::ivec3 size() const { return hi - lo; }
  bool empty() const { return hi.x <= lo.x || hi.y <= lo.y || hi.z <= lo.z; }
};

struct Footprint {
  std::int64_t pages_resident = 0;
  std::int64_t pages_total = 0;
  std::uint64_t bytes = 0;  // device memory held, free pages of begun blocks included
};

class Image3D {
 public:
  virtual ~Image3D() = default;

  VkImage get() const { return image_.get(); }
  VkImageView view() const { return view_.get(); }
  glm::ivec3 extent() const { return extent_; }
  VkFormat format() const { return format_; }

  // The device's own granularity; a dense image is one page. Only whoever splits copies needs it.
  glm::ivec3 page_texels() const { return page_texels_; }
  glm::ivec3 pages() const { return (extent_ + page_texels_ - 1) / page_texels_; }
  TexelBox page_box(glm::ivec3 page) const {
    return {page * page_texels_, glm::min((page + 1) * page_texels_, extent_)};
  }
  // Half-open range of the pages that a box of texels touches.
  TexelBox pages_touching(const TexelBox& box) const {
    return {box.lo / page_texels_, (box.hi + page_texels_ - 1) / page_texels_};
  }

  // Makes memory lie behind every page that the box touches. Pages that had none are appended to
  // fresh: their contents are undefined. Takes effect with flush().
  virtual Result<void> commit(const TexelBox& box, std::vector<glm::ivec3>& fresh) = 0;
  // Takes the memory from one page. Takes effect with flush().
  virtual void release(glm::ivec3 page) = 0;
  // Sends what commit and release collected to the device, in one call.
  virtual Result<void> flush() = 0;

  virtual bool page_committed(glm::ivec3 page) const = 0;
  virtual Footprint footprint() const = 0;

  // Whether a copy of this box is allowed: every page it touches has memory. A write elsewhere is
  // lost on one device and sticks on another, so no copy is recorded without asking this.
  bool committed(const TexelBox& box) const;

 protected:
  // Errors: device (a format that is not filtered, an extent beyond the device's).
  Result<void> make_image(const Device& device, glm::ivec3 extent, VkFormat format, bool sparse,
                          std::string_view name);
  Result<void> make_view(const Device& device, std::string_view name);

  OwnedImage image_;
  OwnedImageView view_;
  glm::ivec3 extent_{0};
  glm::ivec3 page_texels_{1};
  VkFormat format_ = VK_FORMAT_UNDEFINED;
};

// Which room is Device::sparse_store()'s choice. Filled with zeros where dense.
// Errors: device (too large along an axis, format not filtered), out_of_memory.
Result<std::unique_ptr<Image3D>> make_image3d(WorkQueue& queue, glm::ivec3 extent, VkFormat format,
                                              std::string_view name);

// remedy: "" or what the user may do about it, as an appendix to the sentence.
Error too_large_for_one_piece(const Device& device, std::uint64_t bytes, std::uint64_t limit,
                              std::string_view remedy);

std::size_t texel_bytes(VkFormat format);  // R8, R16 (UNORM) and R32_SFLOAT

}  // namespace maille::gpu
