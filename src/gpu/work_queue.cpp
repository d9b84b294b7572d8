#include "gpu/work_queue.h"

#include <array>
#include <limits>

namespace maille::gpu {
namespace {

// Recorded ahead of the device: one for a frame, its copies and a pick, and as many again.
constexpr int kCommandBuffers = 8;

}  // namespace

Result<std::unique_ptr<WorkQueue>> WorkQueue::create(const Device& device) {
  std::unique_ptr<WorkQueue> queue(new WorkQueue(device));

  VkSemaphoreTypeCreateInfo type{};
  type.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO;
  type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
  VkSemaphoreCreateInfo semaphore_info{};
  semaphore_info.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO;
  semaphore_info.pNext = &type;
  VkSemaphore semaphore = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateSemaphore(device.get(), &semaphore_info, nullptr, &semaphore);
      r != VK_SUCCESS) {
    return vk_error(r, "making the timeline");
  }
  queue->timeline_ = {device.get(), semaphore};
  device.set_name(semaphore, VK_OBJECT_TYPE_SEMAPHORE, "timeline");

  VkCommandPoolCreateInfo pool_info{};
  pool_info.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
  pool_info.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pool_info.queueFamilyIndex = device.general().family;
  VkCommandPool pool = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateCommandPool(device.get(), &pool_info, nullptr, &pool);
      r != VK_SUCCESS) {
    return vk_error(r, "making the command pool");
  }
  queue->pool_ = {device.get(), pool};
  device.set_name(pool, VK_OBJECT_TYPE_COMMAND_POOL, "work commands");

  std::array<VkCommandBuffer, kCommandBuffers> buffers{};
  const VkCommandBufferAllocateInfo buffers_info{
      .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
      .pNext = nullptr,
      .commandPool = pool,
      .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
      .commandBufferCount = kCommandBuffers};
  if (const VkResult r = vkAllocateCommandBuffers(device.get(), &buffers_info, buffers.data());
      r != VK_SUCCESS) {
    return vk_error(r, "making command buffers");
  }
  for (const VkCommandBuffer buffer : buffers) {
    device.set_name(buffer, VK_OBJECT_TYPE_COMMAND_BUFFER,
                    "work commands " + std::to_string(queue->slots_.size()));
    queue->slots_.push_back({buffer, 0, false});
  }
  return queue;
}

WorkQueue::~WorkQueue() {
  // Idle, not only past the last value: a software driver's queue thread still touches the timeline
  // for a moment after it was signalled. A lost device has no work left, and nobody to tell.
  vkDeviceWaitIdle(device_->get());
}

Result<VkCommandBuffer> WorkQueue::begin() {
  Slot* oldest = nullptr;
  for (Slot& slot : slots_) {
    if (!slot.recording && (oldest == nullptr || slot.value < oldest->value)) oldest = &slot;
  }
  if (oldest == nullptr) return Error{ErrorKind::failed, "too many command buffers begun at once"};
  if (auto waited = wait(oldest->value); !waited) return waited.error();
  VkCommandBufferBeginInfo info{};
  info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
  info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  if (const VkResult r = vkBeginCommandBuffer(oldest->commands, &info); r != VK_SUCCESS) {
    return vk_error(r, "beginning a command buffer");
  }
  oldest->recording = true;
  return oldest->commands;
}

void WorkQueue::abandon(VkCommandBuffer commands) {
  for (Slot& slot : slots_) {
    if (slot.commands != commands) continue;
    vkEndCommandBuffer(commands);
    slot.recording = false;
  }
}

Result<std::uint64_t> WorkQueue::submit(VkCommandBuffer commands, const PresentSync& present) {
  if (const VkResult r = vkEndCommandBuffer(commands); r != VK_SUCCESS) {
    return vk_error(r, "ending a command buffer");
  }
  const std::uint64_t before = submitted();
  const std::uint64_t after = before + 1;
  // Binary semaphores have no value; the entries beside them are not read.
  const std::array wait_semaphores{timeline_.get(), present.wait};
  const std::array signal_semaphores{timeline_.get(), present.signal};
  const std::array<std::uint64_t, 2> wait_values{before, 0};
  const std::array<std::uint64_t, 2> signal_values{after, 0};
  const std::array<VkPipelineStageFlags, 2> stages{
      VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
      VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT};
  const std::uint32_t waits = present.wait != VK_NULL_HANDLE ? 2 : 1;
  const std::uint32_t signals = present.signal != VK_NULL_HANDLE ? 2 : 1;
  const VkTimelineSemaphoreSubmitInfo values{
      .sType = VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO,
      .pNext = nullptr,
      .waitSemaphoreValueCount = waits,
      .pWaitSemaphoreValues = wait_values.data(),
      .signalSemaphoreValueCount = signals,
      .pSignalSemaphoreValues = signal_values.data()};
  const VkSubmitInfo info{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                          .pNext = &values,
                          .waitSemaphoreCount = waits,
                          .pWaitSemaphores = wait_semaphores.data(),
                          .pWaitDstStageMask = stages.data(),
                          .commandBufferCount = 1,
                          .pCommandBuffers = &commands,
                          .signalSemaphoreCount = signals,
                          .pSignalSemaphores = signal_semaphores.data()};
  const VkResult r = vkQueueSubmit(device_->general().handle, 1, &info, VK_NULL_HANDLE);
  for (Slot& slot : slots_) {
    if (slot.commands != commands) continue;
    slot.recording = false;
    if (r == VK_SUCCESS) slot.value = after;
  }
  if (r != VK_SUCCESS) return vk_error(r, "submitting work");
  submitted_.store(after, std::memory_order_release);
  return after;
}

Result<std::uint64_t> WorkQueue::bind(VkBindSparseInfo info) {
  const std::uint64_t before = submitted();
  const std::uint64_t after = before + 1;
  const VkSemaphore timeline = timeline_.get();
  const VkTimelineSemaphoreSubmitInfo values{
      .sType = VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO,
      .pNext = nullptr,
      .waitSemaphoreValueCount = 1,
      .pWaitSemaphoreValues = &before,
      .signalSemaphoreValueCount = 1,
      .pSignalSemaphoreValues = &after};
  info.sType = VK_STRUCTURE_TYPE_BIND_SPARSE_INFO;
  info.pNext = &values;
  info.waitSemaphoreCount = 1;
  info.pWaitSemaphores = &timeline;
  info.signalSemaphoreCount = 1;
  info.pSignalSemaphores = &timeline;
  if (const VkResult r = vkQueueBindSparse(device_->sparse().handle, 1, &info, VK_NULL_HANDLE);
      r != VK_SUCCESS) {
    return vk_error(r, "binding pages");
  }
  submitted_.store(after, std::memory_order_release);
  return after;
}

Result<std::uint64_t> WorkQueue::completed() const {
  std::uint64_t value = 0;
  if (const VkResult r = vkGetSemaphoreCounterValue(device_->get(), timeline_.get(), &value);
      r != VK_SUCCESS) {
    return vk_error(r, "asking how far the device is");
  }
  return value;
}

Result<void> WorkQueue::wait(std::uint64_t value) const {
  const VkSemaphore timeline = timeline_.get();
  const VkSemaphoreWaitInfo info{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
                                 .pNext = nullptr,
                                 .flags = 0,
                                 .semaphoreCount = 1,
                                 .pSemaphores = &timeline,
                                 .pValues = &value};
  if (const VkResult r =
          vkWaitSemaphores(device_->get(), &info, std::numeric_limits<std::uint64_t>::max());
      r != VK_SUCCESS) {
    return vk_error(r, "waiting for the device");
  }
  return {};
}

void barrier(VkCommandBuffer commands, VkPipelineStageFlags before, VkAccessFlags written,
             VkPipelineStageFlags after, VkAccessFlags read) {
  const VkMemoryBarrier memory{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                               .pNext = nullptr,
                               .srcAccessMask = written,
                               .dstAccessMask = read};
  vkCmdPipelineBarrier(commands, before, after, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

void to_general(VkCommandBuffer commands, VkImage image) {
  const VkImageMemoryBarrier transition{
      .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
      .pNext = nullptr,
      .srcAccessMask = 0,
      .dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT,
      .oldLayout = VK_IMAGE_LAYOUT_UNDEFINED,
      .newLayout = VK_IMAGE_LAYOUT_GENERAL,
      .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
      .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
      .image = image,
      .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT,
                       VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, nullptr, 0, nullptr, 1,
                       &transition);
}

}  // namespace maille::gpu
