// The one line of work that the device does for us.
//
// Every submission - a bind of pages, a copy of bricks, a cast, a present - waits for the one
// before it and signals the next value of ONE timeline semaphore. So bind -> copy -> cast -> next
// copy is ordered, memory included, whatever queue each runs on, and a value that has passed says
// that everything up to it is done. The semaphore is signalled from queues only: signalling it from
// the host to release a queued wait stalls for seconds under validation. Road not taken: copies
// that overlap the cast of the frame before. It needs two images or exact knowledge of which bricks
// the cast reads.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "gpu/device.h"

namespace maille::gpu {

// Binary semaphores of the presentation engine, which knows no timelines.
struct PresentSync {
  VkSemaphore wait = VK_NULL_HANDLE;  // at colour attachment output and transfer
  VkSemaphore signal = VK_NULL_HANDLE;
};

class WorkQueue {
 public:
  static Result<std::unique_ptr<WorkQueue>> create(const Device& device);
  ~WorkQueue();  // waits until all work is done
  WorkQueue(const WorkQueue&) = delete;
  WorkQueue& operator=(const WorkQueue&) = delete;

  // One thread records and submits. begin() waits until one of a few command buffers is free.
  Result<VkCommandBuffer> begin();
  Result<std::uint64_t> submit(VkCommandBuffer commands, const PresentSync& present = {});
  // Gives back a buffer from begin() that will not be submitted.
  void abandon(VkCommandBuffer commands);
  // info brings the binds; its semaphores are set here.
  Result<std::uint64_t> bind(VkBindSparseInfo info);
  // begin, record, submit, wait.
  template <class Record>
  Result<void> run(Record&& record);

  // Any thread.
  std::uint64_t submitted() const { return submitted_.load(std::memory_order_acquire); }
  Result<std::uint64_t> completed() const;
  Result<void> wait(std::uint64_t value) const;
  Result<void> wait_all() const { return wait(submitted()); }

  const Device& device() const { return *device_; }

 private:
  struct Slot {
    VkCommandBuffer commands = VK_NULL_HANDLE;
    std::uint64_t value = 0;  // busy until this has passed
    bool recording = false;
  };

  explicit WorkQueue(const Device& device) : device_(&device) {}

  const Device* device_;
  OwnedSemaphore timeline_;
  OwnedCommandPool pool_;
  std::vector<Slot> slots_;
  std::atomic<std::uint64_t> submitted_{0};
};

template <class Record>
Result<void> WorkQueue::run(Record&& record) {
  auto commands = begin();
  if (!commands) return commands.error();
  record(*commands);
  auto value = submit(*commands);
  if (!value) return value.error();
  return wait(*value);
}

// All reads and writes before, in these stages, before all reads and writes after.
void barrier(VkCommandBuffer commands, VkPipelineStageFlags before, VkAccessFlags written,
             VkPipelineStageFlags after, VkAccessFlags read);

// A new image, contents undefined, to layout GENERAL.
void to_general(VkCommandBuffer commands, VkImage image);

}  // namespace maille::gpu
