#include "gpu/upload_queue.h"

#include <string>

namespace maille::gpu {

Result<void> UploadQueue::add(const StagingRing::Slot& slot, const TexelBox& whole,
                              const TexelBox& part) {
  if (!image_->committed(part)) {
    const auto text = [](glm::ivec3 p) {
      return std::to_string(p.x) + "," + std::to_string(p.y) + "," + std::to_string(p.z);
    };
    return Error{ErrorKind::failed,
                 "copy into texels " + text(part.lo) + " to " + text(part.hi) +
                     " (excluded) of the volume texture, where no page is bound"};
  }
  const auto texel = static_cast<VkDeviceSize>(texel_bytes(image_->format()));
  const glm::ivec3 size = whole.size();
  const glm::ivec3 first = part.lo - whole.lo;
  const VkDeviceSize skipped =
      (static_cast<VkDeviceSize>(first.z) * static_cast<VkDeviceSize>(size.y) +
       static_cast<VkDeviceSize>(first.y)) *
          static_cast<VkDeviceSize>(size.x) +
      static_cast<VkDeviceSize>(first.x);
  const glm::ivec3 extent = part.size();
  regions_.push_back(
      {.bufferOffset = slot.offset() + skipped * texel,
       .bufferRowLength = static_cast<std::uint32_t>(size.x),
       .bufferImageHeight = static_cast<std::uint32_t>(size.y),
       .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
       .imageOffset = {part.lo.x, part.lo.y, part.lo.z},
       .imageExtent = {static_cast<std::uint32_t>(extent.x), static_cast<std::uint32_t>(extent.y),
                       static_cast<std::uint32_t>(extent.z)}});
  bytes_ += static_cast<std::uint64_t>(extent.x) * static_cast<std::uint64_t>(extent.y) *
            static_cast<std::uint64_t>(extent.z) * texel;
  return {};
}

Result<std::uint64_t> UploadQueue::submit() {
  if (auto bound = image_->flush(); !bound) return bound.error();
  std::uint64_t value = queue_->submitted();
  if (!regions_.empty()) {
    auto commands = queue_->begin();
    if (!commands) return commands.error();
    const int timer = timers_ != nullptr ? timers_->start(*commands, "upload") : -1;
    vkCmdCopyBufferToImage(*commands, ring_->buffer(), image_->get(), VK_IMAGE_LAYOUT_GENERAL,
                           static_cast<std::uint32_t>(regions_.size()), regions_.data());
    if (timers_ != nullptr) timers_->stop(*commands, timer);
    auto submitted = queue_->submit(*commands);
    if (!submitted) return submitted.error();
    value = *submitted;
    if (timers_ != nullptr) timers_->submitted(value);
    for (StagingRing::Slot& slot : slots_) std::move(slot).submitted(value);
    regions_.clear();
  }
  slots_.clear();
  return value;
}

}  // namespace maille::gpu
