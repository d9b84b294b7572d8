// Where pictures are presented to: a window's surface, or none at all for tests.
#pragma once

#include "gpu/instance.h"

struct GLFWwindow;

namespace maille::gpu {

// Destroyed before its instance and after every swapchain on it.
class Surface {
 public:
  Surface() = default;
  // window: made with GLFW_CLIENT_API = GLFW_NO_API. Errors: device.
  static Result<Surface> create(Instance& instance, GLFWwindow* window);
  // Needs InstanceOptions.headless_surface.
  static Result<Surface> create_headless(Instance& instance);
  Surface(Surface&& other) noexcept
      : instance_(other.instance_), surface_(std::exchange(other.surface_, VK_NULL_HANDLE)) {}
  Surface& operator=(Surface&& other) noexcept;
  ~Surface();

  VkSurfaceKHR get() const { return surface_; }

 private:
  Surface(VkInstance instance, VkSurfaceKHR surface) : instance_(instance), surface_(surface) {}
  VkInstance instance_ = VK_NULL_HANDLE;
  VkSurfaceKHR surface_ = VK_NULL_HANDLE;
};

}  // namespace maille::gpu
