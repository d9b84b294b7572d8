#include "gpu/staging_ring.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace maille::gpu {
namespace {

constexpr std::uint64_t kLent = std::numeric_limits<std::uint64_t>::max();

// Slots start where copies are fast (128 on the devices seen) and where no texel is torn.
constexpr VkDeviceSize kLeastAlignment = 64;

}  // namespace

StagingRing::Slot& StagingRing::Slot::operator=(Slot&& other) noexcept {
  if (this != &other) {
    if (ring_ != nullptr) ring_->give_back(index_, 0);
    ring_ = std::exchange(other.ring_, nullptr);
    index_ = other.index_;
  }
  return *this;
}

StagingRing::Slot::~Slot() {
  if (ring_ != nullptr) ring_->give_back(index_, 0);
}

std::span<std::byte> StagingRing::Slot::bytes() const {
  return ring_->buffer_.mapped().subspan(offset(), ring_->slot_bytes_);
}

VkDeviceSize StagingRing::Slot::offset() const {
  return static_cast<VkDeviceSize>(index_) * ring_->stride_;
}

void StagingRing::Slot::submitted(std::uint64_t timeline_value) && {
  std::exchange(ring_, nullptr)->give_back(index_, timeline_value);
}

Result<std::unique_ptr<StagingRing>> StagingRing::create(WorkQueue& queue, std::size_t slot_bytes,
                                                         int slots) {
  std::unique_ptr<StagingRing> ring(new StagingRing(queue));
  const VkDeviceSize alignment =
      std::max(kLeastAlignment, queue.device().limits().optimalBufferCopyOffsetAlignment);
  ring->slot_bytes_ = slot_bytes;
  ring->stride_ = (slot_bytes + alignment - 1) / alignment * alignment;
  ring->values_.assign(static_cast<std::size_t>(slots), 0);
  auto buffer =
      Buffer::create(queue.device(), ring->stride_ * static_cast<VkDeviceSize>(slots),
                     VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryUse::staging, "staging ring");
  if (!buffer) return buffer.error();
  ring->buffer_ = std::move(*buffer);
  return ring;
}

StagingRing::~StagingRing() {
  std::uint64_t last = 0;
  for (const std::uint64_t value : values_) {
    assert(value != kLent && "a staging slot outlives its ring");
    last = std::max(last, value);
  }
  if (buffer_) (void)queue_->wait(last);
}

Result<std::optional<StagingRing::Slot>> StagingRing::try_acquire() {
  std::lock_guard lock(mutex_);
  auto completed = queue_->completed();
  if (!completed) return completed.error();
  for (std::size_t i = 0; i < values_.size(); ++i) {
    if (values_[i] > *completed) continue;
    values_[i] = kLent;
    return std::optional<Slot>(Slot(this, static_cast<int>(i)));
  }
  return std::optional<Slot>();
}

Result<StagingRing::Slot> StagingRing::acquire() {
  for (;;) {
    auto slot = try_acquire();
    if (!slot) return slot.error();
    if (slot->has_value()) return std::move(**slot);

    std::unique_lock lock(mutex_);
    const std::uint64_t next = *std::min_element(values_.begin(), values_.end());
    if (next == kLent) {
      // All of them are being filled, or wait to be submitted.
      freed_.wait(lock, [&] {
        return std::any_of(values_.begin(), values_.end(),
                           [](std::uint64_t value) { return value != kLent; });
      });
    } else {
      lock.unlock();
      if (auto waited = queue_->wait(next); !waited) return waited.error();
    }
  }
}

void StagingRing::give_back(int index, std::uint64_t value) {
  {
    std::lock_guard lock(mutex_);
    values_[static_cast<std::size_t>(index)] = value;
  }
  freed_.notify_all();
}

}  // namespace maille::gpu
