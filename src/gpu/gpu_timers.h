// How long the device works on each named pass, from timestamps in its command buffers.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "gpu/work_queue.h"

namespace maille::gpu {

struct PassTime {
  double last_ms = 0.0;
  double total_ms = 0.0;
  std::int64_t count = 0;
};

class GpuTimers {
 public:
  // A device without timestamps gets timers that measure nothing.
  static Result<std::unique_ptr<GpuTimers>> create(WorkQueue& queue);

  // Around a pass in one command buffer; returns what stop() wants. When more passes are in flight
  // than there are queries, the pass goes unmeasured.
  int start(VkCommandBuffer commands, std::string_view pass);
  void stop(VkCommandBuffer commands, int timer);
  // After the submission that holds them.
  void submitted(std::uint64_t value);

  // Of everything done by now.
  const std::map<std::string, PassTime, std::less<>>& times();

 private:
  struct Timer {
    std::string pass;
    std::uint64_t value = 0;
    enum { free, recording, in_flight } state = free;
  };

  explicit GpuTimers(WorkQueue& queue) : queue_(&queue) {}

  WorkQueue* queue_;
  OwnedQueryPool pool_;
  double ms_a_tick_ = 0.0;
  std::uint64_t mask_ = 0;
  std::vector<Timer> timers_;
  std::map<std::string, PassTime, std::less<>> times_;
};

}  // namespace maille::gpu
