// The Vulkan instance, and in validating builds the layer's voice.
//
// Builds with MAILLE_VALIDATION run every call under VK_LAYER_KHRONOS_validation, synchronization
// validation included. What it says is kept, so that a test can assert that it said nothing.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "gpu/handle.h"

namespace maille::gpu {

// Warnings and errors of the validation layer. Calls may come from any thread that calls Vulkan.
class ValidationLog {
 public:
  void add(std::string message);
  std::size_t count() const;
  std::vector<std::string> take();  // and forgets them

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> messages_;
};

struct InstanceOptions {
  // Surface extensions. GLFW must be initialised; false leaves GLFW untouched.
  bool window = false;
  // VK_EXT_headless_surface, so that tests can present without a display.
  bool headless_surface = false;
  // Print messages on stderr as they come; they are kept either way.
  bool print_messages = false;
  // Where they are kept; the instance makes one of its own if there is none. A log that outlives
  // the instance also hears what is said of its end.
  std::shared_ptr<ValidationLog> log = nullptr;
};

class Instance {
 public:
  // Errors: device (no loader or driver, no validation layer in a validating build, no surface
  // extension when a window is asked for).
  static Result<std::unique_ptr<Instance>> create(const InstanceOptions& options = {});
  ~Instance();
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  VkInstance get() const { return instance_; }
  ValidationLog& validation_log() { return *options_.log; }
  bool validating() const { return messenger_ != VK_NULL_HANDLE; }
  bool print_messages() const { return options_.print_messages; }
  const InstanceOptions& options() const { return options_; }

 private:
  explicit Instance(const InstanceOptions& options) : options_(options) {
    if (!options_.log) options_.log = std::make_shared<ValidationLog>();
  }

  InstanceOptions options_;
  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
};

}  // namespace maille::gpu
