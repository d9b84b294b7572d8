// Mapped memory lent to any thread, to be filled and copied to the device.
//
// A slot is lent, filled, handed to the copy and free again when the copy's timeline value has
// passed. acquire() blocks until there is one: whoever acquires more slots than the ring has before
// anything is submitted waits for ever, so a producer runs on another thread than the one that
// submits, or asks with try_acquire().
#pragma once

#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "gpu/buffer.h"
#include "gpu/work_queue.h"

namespace maille::gpu {

class StagingRing {
 public:
  // A lent slot. Dropping it gives it back unused.
  class Slot {
   public:
    Slot(Slot&& other) noexcept
        : ring_(std::exchange(other.ring_, nullptr)), index_(other.index_) {}
    Slot& operator=(Slot&& other) noexcept;
    ~Slot();

    std::span<std::byte> bytes() const;
    VkDeviceSize offset() const;  // within StagingRing::buffer()

    // The copy out of it is signalled by this value: free again once that has passed.
    void submitted(std::uint64_t timeline_value) &&;

   private:
    friend class StagingRing;
    Slot(StagingRing* ring, int index) : ring_(ring), index_(index) {}
    StagingRing* ring_;
    int index_;
  };

  static Result<std::unique_ptr<StagingRing>> create(WorkQueue& queue, std::size_t slot_bytes,
                                                     int slots);
  ~StagingRing();  // waits for the copies; every slot must have come back
  StagingRing(const StagingRing&) = delete;
  StagingRing& operator=(const StagingRing&) = delete;

  // Any thread. Errors: device (lost while waiting).
  Result<Slot> acquire();
  Result<std::optional<Slot>> try_acquire();

  int slot_count() const { return static_cast<int>(values_.size()); }
  std::size_t slot_bytes() const { return slot_bytes_; }
  VkBuffer buffer() const { return buffer_.get(); }
  std::uint64_t bytes() const { return buffer_.bytes(); }

 private:
  explicit StagingRing(WorkQueue& queue) : queue_(&queue) {}
  void give_back(int index, std::uint64_t value);

  WorkQueue* queue_;
  Buffer buffer_;
  std::size_t slot_bytes_ = 0;
  std::size_t stride_ = 0;
  std::mutex mutex_;
  std::condition_variable freed_;
  std::vector<std::uint64_t> values_;  // by slot: the value that frees it, 0 = free, lent = max
};

}  // namespace maille::gpu
