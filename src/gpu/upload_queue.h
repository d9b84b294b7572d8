// Copies from staging memory into a 3D image: one command a batch, so that a batch is seen whole or
// not at all by whatever is submitted after it.
#pragma once

#include <vector>

#include "gpu/gpu_timers.h"
#include "gpu/image3d.h"
#include "gpu/staging_ring.h"

namespace maille::gpu {

class UploadQueue {
 public:
  UploadQueue(WorkQueue& queue, StagingRing& ring, Image3D& image, GpuTimers* timers = nullptr)
      : queue_(&queue), ring_(&ring), image_(&image), timers_(timers) {}

  // Copies part of a brick. The slot holds the texels of `whole`, tightly packed, x fastest; `part`
  // lies in it. Errors: failed (part touches a page without memory: it would be lost or, worse,
  // stick there unseen).
  Result<void> add(const StagingRing::Slot& slot, const TexelBox& whole, const TexelBox& part);
  // No more parts of this slot will come. A slot without any part is better dropped: here it is
  // lent until the batch is done.
  void finish(StagingRing::Slot slot) { slots_.push_back(std::move(slot)); }

  bool empty() const { return regions_.empty() && slots_.empty(); }
  // Binds, then copies. Returns the value that says it is done.
  Result<std::uint64_t> submit();

  std::uint64_t bytes() const { return bytes_; }  // copied since creation

 private:
  WorkQueue* queue_;
  StagingRing* ring_;
  Image3D* image_;
  GpuTimers* timers_;
  std::vector<VkBufferImageCopy> regions_;
  std::vector<StagingRing::Slot> slots_;
  std::uint64_t bytes_ = 0;
};

}  // namespace maille::gpu
