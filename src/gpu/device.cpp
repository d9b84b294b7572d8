#include "gpu/device.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstring>
#include <optional>

namespace maille::gpu {
namespace {

std::vector<VkQueueFamilyProperties> families_of(VkPhysicalDevice physical) {
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
  return families;
}

// The first family with all of the flags, preferring one with `better` too.
std::optional<std::uint32_t> family_with(const std::vector<VkQueueFamilyProperties>& families,
                                         VkQueueFlags flags, VkQueueFlags better = 0) {
  for (const VkQueueFlags wanted : {flags | better, flags}) {
    for (std::uint32_t i = 0; i < families.size(); ++i) {
      if ((families[i].queueFlags & wanted) == wanted) return i;
    }
  }
  return std::nullopt;
}

// Transfer need not be listed where graphics or compute is. Graphics, because a window's overlay is
// drawn and a blit is a graphics command.
constexpr VkQueueFlags kGeneral = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;

bool contains_ignoring_case(std::string_view text, std::string_view part) {
  const auto same = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) ==
           std::tolower(static_cast<unsigned char>(b));
  };
  return std::search(text.begin(), text.end(), part.begin(), part.end(), same) != text.end();
}

Result<std::vector<VkPhysicalDevice>> physical_devices(const Instance& instance) {
  std::uint32_t count = 0;
  VkResult r = vkEnumeratePhysicalDevices(instance.get(), &count, nullptr);
  std::vector<VkPhysicalDevice> devices(count);
  if (r == VK_SUCCESS) r = vkEnumeratePhysicalDevices(instance.get(), &count, devices.data());
  if (r != VK_SUCCESS && r != VK_INCOMPLETE) {
    return Error{ErrorKind::device, vk_error(r, "looking for devices").message};
  }
  devices.resize(count);
  return devices;
}

DeviceInfo info_of(VkPhysicalDevice physical, int index) {
  DeviceInfo info;
  info.index = index;
  VkPhysicalDeviceProperties core{};
  vkGetPhysicalDeviceProperties(physical, &core);
  info.name = core.deviceName;
  info.type = core.deviceType;
  const auto families = families_of(physical);
  if (core.apiVersion < VK_API_VERSION_1_2) {
    info.unusable = "Vulkan " + std::to_string(VK_API_VERSION_MAJOR(core.apiVersion)) + "." +
                    std::to_string(VK_API_VERSION_MINOR(core.apiVersion)) + ", 1.2 is needed";
    return info;
  }

  VkPhysicalDeviceDriverProperties driver{};
  driver.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES;
  VkPhysicalDeviceProperties2 properties{};
  properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
  properties.pNext = &driver;
  vkGetPhysicalDeviceProperties2(physical, &properties);
  info.driver = std::string(driver.driverName) + " " + driver.driverInfo;

  VkPhysicalDeviceVulkan12Features features12{};
  features12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
  VkPhysicalDeviceFeatures2 features{};
  features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
  features.pNext = &features12;
  vkGetPhysicalDeviceFeatures2(physical, &features);
  info.sparse = features.features.sparseBinding && features.features.sparseResidencyImage3D &&
                family_with(families, VK_QUEUE_SPARSE_BINDING_BIT).has_value();
  if (!features12.timelineSemaphore) info.unusable = "no timeline semaphores";
  if (!family_with(families, kGeneral)) info.unusable = "no queue for graphics and compute";
  return info;
}

std::string listing(std::span<const DeviceInfo> devices) {
  std::string text;
  for (const DeviceInfo& device : devices) {
    text += "\n  " + std::to_string(device.index) + "  " + device.name + " (" +
            std::string(name_of(device.type)) + ")";
    if (!device.unusable.empty()) text += " - not usable: " + device.unusable;
  }
  return text;
}

// Only CPUs come after OTHER: nothing is known about OTHER, a CPU is known to be slow.
int rank(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU: return 0;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU: return 1;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU: return 2;
    case VK_PHYSICAL_DEVICE_TYPE_CPU: return 4;
    default: return 3;
  }
}

}  // namespace

std::string_view name_of(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU: return "discrete";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU: return "integrated";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU: return "virtual";
    case VK_PHYSICAL_DEVICE_TYPE_CPU: return "cpu";
    default: return "other";
  }
}

Result<std::vector<DeviceInfo>> list_devices(const Instance& instance) {
  auto devices = physical_devices(instance);
  if (!devices) return devices.error();
  std::vector<DeviceInfo> infos;
  for (const VkPhysicalDevice device : *devices) {
    infos.push_back(info_of(device, static_cast<int>(infos.size())));
  }
  return infos;
}

Result<int> choose_device(std::span<const DeviceInfo> devices, std::string_view name) {
  if (devices.empty()) return Error{ErrorKind::device, "no Vulkan device on this machine"};

  int index = -1;
  const auto [end, problem] = std::from_chars(name.data(), name.data() + name.size(), index);
  const bool by_index = !name.empty() && problem == std::errc() && end == name.data() + name.size();

  const DeviceInfo* best = nullptr;
  const DeviceInfo* refused = nullptr;
  for (const DeviceInfo& device : devices) {
    const bool meant = by_index ? device.index == index
                                : name.empty() || contains_ignoring_case(device.name, name);
    if (!meant) continue;
    if (!device.unusable.empty()) {
      refused = &device;
    } else if (best == nullptr || rank(device.type) < rank(best->type)) {
      best = &device;
    }
  }
  if (best != nullptr) return best->index;
  std::string why = name.empty() ? "no usable Vulkan device"
                    : refused == nullptr
                        ? "no Vulkan device fits '" + std::string(name) + "'"
                        : "device '" + refused->name + "' cannot be used: " + refused->unusable;
  return Error{ErrorKind::device, why + "; there are:" + listing(devices)};
}

Result<std::unique_ptr<Device>> Device::create(Instance& instance, const DeviceOptions& options) {
  auto physicals = physical_devices(instance);
  if (!physicals) return physicals.error();
  auto infos = list_devices(instance);
  if (!infos) return infos.error();
  auto chosen = choose_device(*infos, options.name);
  if (!chosen) return chosen.error();

  std::unique_ptr<Device> device(new Device(instance));
  device->info_ = (*infos)[*chosen];
  device->physical_ = (*physicals)[*chosen];
  const DeviceInfo& info = device->info_;
  const VkPhysicalDevice physical = device->physical_;

  if (options.store == Store::sparse && !info.sparse) {
    return Error{ErrorKind::device,
                 "device '" + info.name + "' has no sparse 3D images; take the dense volume store"};
  }
  device->sparse_store_ =
      options.store == Store::sparse || (options.store == Store::automatic && info.sparse &&
                                         rank(info.type) < rank(VK_PHYSICAL_DEVICE_TYPE_CPU));

  VkPhysicalDeviceProperties properties{};
  vkGetPhysicalDeviceProperties(physical, &properties);
  device->limits_ = properties.limits;
  vkGetPhysicalDeviceMemoryProperties(physical, &device->memory_);

  const auto families = families_of(physical);
  const auto sparse_bit =
      device->sparse_store_ ? VkQueueFlags{VK_QUEUE_SPARSE_BINDING_BIT} : VkQueueFlags{0};
  device->general_.family = *family_with(families, kGeneral, sparse_bit);
  device->sparse_.family = device->general_.family;
  if ((families[device->general_.family].queueFlags & sparse_bit) != sparse_bit) {
    device->sparse_.family = *family_with(families, sparse_bit);
  }
  device->timestamp_bits_ = families[device->general_.family].timestampValidBits;

  const float priority = 1.0f;
  std::vector<VkDeviceQueueCreateInfo> queues;
  for (const std::uint32_t family : {device->general_.family, device->sparse_.family}) {
    if (!queues.empty() && queues.front().queueFamilyIndex == family) continue;
    queues.push_back({.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                      .pNext = nullptr,
                      .flags = 0,
                      .queueFamilyIndex = family,
                      .queueCount = 1,
                      .pQueuePriorities = &priority});
  }

  std::vector<const char*> extensions;
  if (options.window) extensions.push_back(VK_KHR_SWAPCHAIN_EXTENSION_NAME);

  VkPhysicalDeviceVulkan12Features features12{};
  features12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
  features12.timelineSemaphore = VK_TRUE;
  VkPhysicalDeviceFeatures2 features{};
  features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
  features.pNext = &features12;
  features.features.sparseBinding = device->sparse_store_;
  features.features.sparseResidencyImage3D = device->sparse_store_;

  const VkDeviceCreateInfo create{
      .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
      .pNext = &features,
      .flags = 0,
      .queueCreateInfoCount = static_cast<std::uint32_t>(queues.size()),
      .pQueueCreateInfos = queues.data(),
      .enabledLayerCount = 0,
      .ppEnabledLayerNames = nullptr,
      .enabledExtensionCount = static_cast<std::uint32_t>(extensions.size()),
      .ppEnabledExtensionNames = extensions.data(),
      .pEnabledFeatures = nullptr};
  if (const VkResult r = vkCreateDevice(physical, &create, nullptr, &device->device_);
      r != VK_SUCCESS) {
    return vk_error(r, "opening device '" + info.name + "'");
  }
  for (Queue* queue : {&device->general_, &device->sparse_}) {
    vkGetDeviceQueue(device->device_, queue->family, 0, &queue->handle);
  }
  if (instance.validating()) {
    device->set_object_name_ = reinterpret_cast<PFN_vkSetDebugUtilsObjectNameEXT>(
        vkGetInstanceProcAddr(instance.get(), "vkSetDebugUtilsObjectNameEXT"));
  }
  device->set_name(device->general_.handle, VK_OBJECT_TYPE_QUEUE, "general queue");
  return device;
}

Device::~Device() {
  if (device_ == VK_NULL_HANDLE) return;
  vkDeviceWaitIdle(device_);
  vkDestroyDevice(device_, nullptr);
}

void Device::set_name(std::uint64_t handle, VkObjectType type, std::string_view name) const {
  if (set_object_name_ == nullptr) return;
  const std::string text(name);
  const VkDebugUtilsObjectNameInfoEXT info{
      .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
      .pNext = nullptr,
      .objectType = type,
      .objectHandle = handle,
      .pObjectName = text.c_str()};
  set_object_name_(device_, &info);
}

}  // namespace maille::gpu
