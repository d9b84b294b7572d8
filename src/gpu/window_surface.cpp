#include "gpu/window_surface.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace maille::gpu {

Result<Surface> Surface::create(Instance& instance, GLFWwindow* window) {
  VkSurfaceKHR surface = VK_NULL_HANDLE;
  if (const VkResult r = glfwCreateWindowSurface(instance.get(), window, nullptr, &surface);
      r != VK_SUCCESS) {
    return vk_error(r, "making the window's surface");
  }
  return Surface(instance.get(), surface);
}

Result<Surface> Surface::create_headless(Instance& instance) {
  const auto create = reinterpret_cast<PFN_vkCreateHeadlessSurfaceEXT>(
      vkGetInstanceProcAddr(instance.get(), "vkCreateHeadlessSurfaceEXT"));
  if (create == nullptr) return Error{ErrorKind::device, "Vulkan: no headless surfaces here"};
  VkHeadlessSurfaceCreateInfoEXT info{};
  info.sType = VK_STRUCTURE_TYPE_HEADLESS_SURFACE_CREATE_INFO_EXT;
  VkSurfaceKHR surface = VK_NULL_HANDLE;
  if (const VkResult r = create(instance.get(), &info, nullptr, &surface); r != VK_SUCCESS) {
    return vk_error(r, "making a headless surface");
  }
  return Surface(instance.get(), surface);
}

Surface& Surface::operator=(Surface&& other) noexcept {
  if (this != &other) {
    if (surface_ != VK_NULL_HANDLE) vkDestroySurfaceKHR(instance_, surface_, nullptr);
    instance_ = other.instance_;
    surface_ = std::exchange(other.surface_, VK_NULL_HANDLE);
  }
  return *this;
}

Surface::~Surface() {
  if (surface_ != VK_NULL_HANDLE) vkDestroySurfaceKHR(instance_, surface_, nullptr);
}

}  // namespace maille::gpu
