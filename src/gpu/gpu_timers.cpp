#include "gpu/gpu_timers.h"

#include <array>

namespace maille::gpu {
namespace {

// Passes in flight at once: more than the work queue has command buffers.
constexpr int kTimers = 64;

}  // namespace

Result<std::unique_ptr<GpuTimers>> GpuTimers::create(WorkQueue& queue) {
  std::unique_ptr<GpuTimers> timers(new GpuTimers(queue));
  const Device& device = queue.device();
  if (device.timestamp_bits() == 0) return timers;
  const VkQueryPoolCreateInfo info{.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                   .pNext = nullptr,
                                   .flags = 0,
                                   .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                   .queryCount = 2 * kTimers,
                                   .pipelineStatistics = 0};
  VkQueryPool pool = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateQueryPool(device.get(), &info, nullptr, &pool); r != VK_SUCCESS) {
    return vk_error(r, "making timers");
  }
  timers->pool_ = {device.get(), pool};
  device.set_name(pool, VK_OBJECT_TYPE_QUERY_POOL, "pass timers");
  timers->ms_a_tick_ = static_cast<double>(device.limits().timestampPeriod) * 1e-6;
  timers->mask_ = device.timestamp_bits() >= 64 ? ~std::uint64_t{0}
                                                : (std::uint64_t{1} << device.timestamp_bits()) - 1;
  timers->timers_.resize(kTimers);
  return timers;
}

int GpuTimers::start(VkCommandBuffer commands, std::string_view pass) {
  for (int attempt = 0; attempt < 2; ++attempt) {
    for (std::size_t i = 0; i < timers_.size(); ++i) {
      Timer& timer = timers_[i];
      if (timer.state != Timer::free) continue;
      timer.state = Timer::recording;
      timer.pass = pass;
      const auto query = static_cast<std::uint32_t>(2 * i);
      vkCmdResetQueryPool(commands, pool_.get(), query, 2);
      vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, pool_.get(), query);
      return static_cast<int>(i);
    }
    times();  // frees what is done
  }
  return -1;
}

void GpuTimers::stop(VkCommandBuffer commands, int timer) {
  if (timer < 0) return;
  vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, pool_.get(),
                      static_cast<std::uint32_t>(2 * timer + 1));
}

void GpuTimers::submitted(std::uint64_t value) {
  for (Timer& timer : timers_) {
    if (timer.state != Timer::recording) continue;
    timer.state = Timer::in_flight;
    timer.value = value;
  }
}

const std::map<std::string, PassTime, std::less<>>& GpuTimers::times() {
  const auto completed = queue_->completed();
  if (!completed) return times_;
  for (std::size_t i = 0; i < timers_.size(); ++i) {
    Timer& timer = timers_[i];
    if (timer.state != Timer::in_flight || timer.value > *completed) continue;
    timer.state = Timer::free;
    std::array<std::uint64_t, 2> ticks{};
    const VkResult r = vkGetQueryPoolResults(queue_->device().get(), pool_.get(),
                                             static_cast<std::uint32_t>(2 * i), 2, sizeof ticks,
                                             ticks.data(), sizeof ticks[0], VK_QUERY_RESULT_64_BIT);
    if (r != VK_SUCCESS) continue;
    PassTime& time = times_[timer.pass];
    time.last_ms = static_cast<double>((ticks[1] - ticks[0]) & mask_) * ms_a_tick_;
    time.total_ms += time.last_ms;
    ++time.count;
  }
  return times_;
}

}  // namespace maille::gpu
