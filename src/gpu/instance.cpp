#include "gpu/instance.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <string_view>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace maille::gpu {
namespace {

#ifdef MAILLE_VALIDATION
constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

// The volume image lives in GENERAL, because three kinds of work take turns on it; that copies
// would like another layout better is a hint about speed that we have weighed. Every other message
// counts.
bool is_general_layout_hint(const VkDebugUtilsMessengerCallbackDataEXT& data) {
  return data.pMessageIdName != nullptr && data.pMessage != nullptr &&
         std::strcmp(data.pMessageIdName,
                     "UNASSIGNED-CoreValidation-DrawState-InvalidImageLayout") == 0 &&
         std::strstr(data.pMessage, "For optimal performance") != nullptr;
}

VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                          VkDebugUtilsMessageTypeFlagsEXT type,
                                          const VkDebugUtilsMessengerCallbackDataEXT* data,
                                          void* user) {
  const bool performance = (type & VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT) != 0;
  if (performance && is_general_layout_hint(*data)) return VK_FALSE;
  auto& instance = *static_cast<Instance*>(user);
  const bool error = (severity & VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT) != 0;
  std::string text = error ? "error: " : performance ? "performance warning: " : "warning: ";
  text += data->pMessage;
  if (instance.print_messages()) std::fprintf(stderr, "vulkan %s\n", text.c_str());
  instance.validation_log().add(std::move(text));
  return VK_FALSE;
}

bool has_layer(const char* name) {
  std::uint32_t count = 0;
  vkEnumerateInstanceLayerProperties(&count, nullptr);
  std::vector<VkLayerProperties> layers(count);
  vkEnumerateInstanceLayerProperties(&count, layers.data());
  return std::any_of(layers.begin(), layers.end(),
                     [&](const auto& layer) { return std::strcmp(layer.layerName, name) == 0; });
}
#endif

bool has_extension(const char* name) {
  std::uint32_t count = 0;
  vkEnumerateInstanceExtensionProperties(nullptr, &count, nullptr);
  std::vector<VkExtensionProperties> extensions(count);
  vkEnumerateInstanceExtensionProperties(nullptr, &count, extensions.data());
  return std::any_of(extensions.begin(), extensions.end(), [&](const auto& extension) {
    return std::strcmp(extension.extensionName, name) == 0;
  });
}

}  // namespace

void ValidationLog::add(std::string message) {
  std::lock_guard lock(mutex_);
  messages_.push_back(std::move(message));
}

std::size_t ValidationLog::count() const {
  std::lock_guard lock(mutex_);
  return messages_.size();
}

std::vector<std::string> ValidationLog::take() {
  std::lock_guard lock(mutex_);
  return std::exchange(messages_, {});
}

Result<std::unique_ptr<Instance>> Instance::create(const InstanceOptions& options) {
  std::unique_ptr<Instance> instance(new Instance(options));
  std::vector<const char*> extensions;
  std::vector<const char*> layers;

  if (options.window) {
    std::uint32_t count = 0;
    const char** names = glfwGetRequiredInstanceExtensions(&count);
    if (names == nullptr) {
      return Error{ErrorKind::device, "Vulkan: this machine cannot present to a window"};
    }
    extensions.assign(names, names + count);
  }
  if (options.headless_surface) {
    for (const char* name :
         {VK_KHR_SURFACE_EXTENSION_NAME, VK_EXT_HEADLESS_SURFACE_EXTENSION_NAME}) {
      if (!has_extension(name)) {
        return Error{ErrorKind::device, "Vulkan: no " + std::string(name) + " on this machine"};
      }
      extensions.push_back(name);
    }
  }
  // Drivers that are not wholly conformant are hidden without it.
  VkInstanceCreateFlags flags = 0;
  if (has_extension(VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME)) {
    extensions.push_back(VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME);
    flags |= VK_INSTANCE_CREATE_ENUMERATE_PORTABILITY_BIT_KHR;
  }

  const void* next = nullptr;
#ifdef MAILLE_VALIDATION
  if (!has_layer(kValidationLayer)) {
    return Error{ErrorKind::device, "Vulkan: this build validates every call and " +
                                        std::string(kValidationLayer) +
                                        " is not installed (tools/setup installs it)"};
  }
  layers.push_back(kValidationLayer);
  extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
  // Only what concerns our calls: the loader's own remarks are of type GENERAL.
  VkDebugUtilsMessengerCreateInfoEXT messenger{
      .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
      .pNext = nullptr,
      .flags = 0,
      .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                         VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
      .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                     VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
      .pfnUserCallback = on_message,
      .pUserData = instance.get()};
  const std::array enabled{VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
  const VkValidationFeaturesEXT features{.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                         .pNext = &messenger,
                                         .enabledValidationFeatureCount = enabled.size(),
                                         .pEnabledValidationFeatures = enabled.data(),
                                         .disabledValidationFeatureCount = 0,
                                         .pDisabledValidationFeatures = nullptr};
  next = &features;
#endif

  const VkApplicationInfo application{.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                      .pNext = nullptr,
                                      .pApplicationName = "Maille",
                                      .applicationVersion = 0,
                                      .pEngineName = "Maille",
                                      .engineVersion = 0,
                                      .apiVersion = VK_API_VERSION_1_2};
  const VkInstanceCreateInfo info{
      .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
      .pNext = next,
      .flags = flags,
      .pApplicationInfo = &application,
      .enabledLayerCount = static_cast<std::uint32_t>(layers.size()),
      .ppEnabledLayerNames = layers.data(),
      .enabledExtensionCount = static_cast<std::uint32_t>(extensions.size()),
      .ppEnabledExtensionNames = extensions.data()};
  if (const VkResult r = vkCreateInstance(&info, nullptr, &instance->instance_); r != VK_SUCCESS) {
    return Error{ErrorKind::device, vk_error(r, "starting it").message};
  }
#ifdef MAILLE_VALIDATION
  const auto create_messenger = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
      vkGetInstanceProcAddr(instance->instance_, "vkCreateDebugUtilsMessengerEXT"));
  if (const VkResult r =
          create_messenger(instance->instance_, &messenger, nullptr, &instance->messenger_);
      r != VK_SUCCESS) {
    return vk_error(r, "listening to the validation layer");
  }
#endif
  return instance;
}

Instance::~Instance() {
  if (messenger_ != VK_NULL_HANDLE) {
    const auto destroy_messenger = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"));
    destroy_messenger(instance_, messenger_, nullptr);
  }
  if (instance_ != VK_NULL_HANDLE) vkDestroyInstance(instance_, nullptr);
}

}  // namespace maille::gpu
