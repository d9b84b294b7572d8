// A 3D image whose pages get memory one by one.
//
// The granularity is the device's (32^3 texels of 16 bits here, 128x64x4 there). An image smaller
// than a page lies wholly in the mip tail: it is then one page that is always bound.
// No shader asks for residency: the instruction for it is missing or broken on some drivers, so who
// samples knows from elsewhere what is there.
#pragma once

#include <optional>

#include "gpu/image3d.h"
#include "gpu/page_pool.h"

namespace maille::gpu {

class SparseImage final : public Image3D {
 public:
  static Result<std::unique_ptr<Image3D>> create(WorkQueue& queue, glm::ivec3 extent,
                                                 VkFormat format, std::string_view name);
  ~SparseImage() override;

  Result<void> commit(const TexelBox& box, std::vector<glm::ivec3>& fresh) override;
  void release(glm::ivec3 page) override;
  Result<void> flush() override;
  bool page_committed(glm::ivec3 page) const override;
  Footprint footprint() const override;

 private:
  explicit SparseImage(WorkQueue& queue) : queue_(&queue) {}
  Result<void> bind_tail(const VkSparseImageMemoryRequirements& part,
                         const VkMemoryRequirements& needs, bool metadata);
  std::size_t index(glm::ivec3 page) const;
  void queue_bind(glm::ivec3 page, std::optional<Page> memory);

  WorkQueue* queue_;
  std::optional<PagePool> pool_;
  std::vector<OwnedMemory> tails_;
  std::vector<std::optional<Page>> resident_;   // by page, x fastest: the CPU's residency map
  std::vector<VkSparseImageMemoryBind> binds_;  // not yet sent
  std::vector<Page> leaving_;                   // free for others once the unbind is sent
  std::int64_t resident_count_ = 0;
  std::uint64_t tail_bytes_ = 0;
  bool all_in_tail_ = false;
};

}  // namespace maille::gpu
