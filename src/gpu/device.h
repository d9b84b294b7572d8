// The device that is used: which one, what of it is enabled, its queues.
//
// Nothing is enabled that was not asked for: sparse features only for the sparse store, the
// swapchain extension only for a window.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gpu/instance.h"

namespace maille::gpu {

struct DeviceInfo {
  int index = 0;  // what --device takes
  std::string name;
  std::string driver;  // name, and version as the driver writes it
  VkPhysicalDeviceType type = VK_PHYSICAL_DEVICE_TYPE_OTHER;
  bool sparse = false;   // sparse 3D images and a queue that binds them
  std::string unusable;  // empty, or what it lacks ("Vulkan 1.1 only")
};

std::string_view name_of(VkPhysicalDeviceType type);  // "discrete", "cpu", …

// Every device of the machine in the driver's order. Errors: device.
Result<std::vector<DeviceInfo>> list_devices(const Instance& instance);

// The index that DeviceOptions.name picks: a whole number is an index, other text a part of the
// name in any case; empty prefers discrete over integrated over virtual over cpu, then the first.
// Errors: device, listing what there is.
Result<int> choose_device(std::span<const DeviceInfo> devices, std::string_view name);

enum class Store {
  automatic,  // sparse where the device has it and is no CPU: there a copy into a sparse image is
              // forty times slower than into a dense one
  sparse,     // pages bound one by one; error where the device has none
  dense,
};

struct DeviceOptions {
  std::string name = {};
  Store store = Store::automatic;
  bool window = false;
};

// A family's queue. One queue may play several parts, then the handles are equal.
struct Queue {
  VkQueue handle = VK_NULL_HANDLE;
  std::uint32_t family = 0;
};

class Device {
 public:
  // Errors: device.
  static Result<std::unique_ptr<Device>> create(Instance& instance, const DeviceOptions& options);
  ~Device();  // waits until it is idle
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  VkDevice get() const { return device_; }
  VkPhysicalDevice physical() const { return physical_; }
  Instance& instance() const { return *instance_; }
  const DeviceInfo& info() const { return info_; }
  const VkPhysicalDeviceLimits& limits() const { return limits_; }
  const VkPhysicalDeviceMemoryProperties& memory() const { return memory_; }

  bool sparse_store() const { return sparse_store_; }  // what Store::automatic came to
  const Queue& general() const { return general_; }    // graphics, compute and transfer
  const Queue& sparse() const { return sparse_; }      // sparse binding; general where it can
  std::uint32_t timestamp_bits() const { return timestamp_bits_; }

  // Shown in validation messages and frame debuggers. Does nothing when not validating.
  template <class Handle>
  void set_name(Handle handle, VkObjectType type, std::string_view name) const {
    set_name(reinterpret_cast<std::uint64_t>(handle), type, name);
  }
  void set_name(std::uint64_t handle, VkObjectType type, std::string_view name) const;

 private:
  explicit Device(Instance& instance) : instance_(&instance) {}

  Instance* instance_;
  DeviceInfo info_;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkDevice device_ = VK_NULL_HANDLE;
  VkPhysicalDeviceLimits limits_{};
  VkPhysicalDeviceMemoryProperties memory_{};
  Queue general_;
  Queue sparse_;
  std::uint32_t timestamp_bits_ = 0;
  bool sparse_store_ = false;
  PFN_vkSetDebugUtilsObjectNameEXT set_object_name_ = nullptr;
};

}  // namespace maille::gpu
