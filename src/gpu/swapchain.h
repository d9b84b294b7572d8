// Pictures onto a window.
//
// A picture reaches the window by a blit, which converts: the surface may be BGRA, may not take
// storage writes, may be of another size. Then an overlay (Dear ImGui) is drawn over it.
#pragma once

#include <memory>
#include <vector>

#include "gpu/image2d.h"
#include "gpu/overlay_pass.h"
#include "gpu/window_surface.h"
#include "gpu/work_queue.h"

namespace maille::gpu {

class Swapchain {
 public:
  // vsync: FIFO; otherwise whichever of mailbox and immediate there is.
  // Errors: device (the device cannot present to the surface).
  static Result<std::unique_ptr<Swapchain>> create(WorkQueue& queue, VkSurfaceKHR surface,
                                                   bool vsync);
  ~Swapchain();
  Swapchain(const Swapchain&) = delete;
  Swapchain& operator=(const Swapchain&) = delete;

  // Blits the picture over the window, draws the overlay, presents. window: framebuffer size in
  // pixels, as GLFW tells it. False: nothing was shown (minimised, or the window changed under our
  // hands) - draw again. Without a picture the window is cleared.
  Result<bool> present(const Image2D* picture, VkExtent2D window, const DrawOverlay& overlay);

  OverlayTarget overlay_target() const;

 private:
  struct Acquire {
    OwnedSemaphore semaphore;
    std::uint64_t value = 0;  // free again when this has passed
  };
  struct Target {
    VkImage image = VK_NULL_HANDLE;
    OwnedImageView view;
    OwnedFramebuffer framebuffer;
    OwnedSemaphore rendered;  // one an image: presentation may still hold the last one's
  };

  Swapchain(WorkQueue& queue, VkSurfaceKHR surface) : queue_(&queue), surface_(surface) {}
  Result<void> choose_format();
  // False: the window has no area.
  Result<bool> rebuild(VkExtent2D window);
  Result<OwnedSemaphore> make_semaphore(std::string_view name) const;
  Result<Target> make_target(VkImage image) const;
  void record(VkCommandBuffer commands, const Image2D* picture, const Target& target,
              const DrawOverlay& overlay) const;

  WorkQueue* queue_;
  VkSurfaceKHR surface_;
  VkSurfaceFormatKHR format_{};
  VkPresentModeKHR mode_ = VK_PRESENT_MODE_FIFO_KHR;
  bool srgb_ = false;  // the surface encodes what it is given, so it must be given decoded colours
  OverlayPass overlay_;
  OwnedSwapchain swapchain_;
  VkExtent2D extent_{};
  VkExtent2D asked_{};
  std::uint32_t image_count_ = 2;
  std::vector<Target> targets_;
  std::vector<Acquire> acquires_;
  std::size_t next_acquire_ = 0;
  Image2D srgb_copy_;  // the picture, declared to be encoded; empty unless srgb_
  bool stale_ = true;
};

}  // namespace maille::gpu
