// What sanitizers find in drivers and layers, and is not ours to mend.
//
// Linked into each program that loads them, in builds with a sanitizer only.
#if defined(__SANITIZE_ADDRESS__)

#include "gpu/instance.h"

extern "C" const char* __lsan_default_suppressions() {
  return "leak:libvulkan\nleak:libVkLayer\nleak:libLLVM\nleak:libgallium\nleak:_dl_\n";
}
// Tests look at what a program says.
extern "C" const char* __lsan_default_options() { return "print_suppressions=0"; }

namespace maille::gpu {
namespace {
// The leak sanitizer can tell whose a leak is only while the library is loaded, so an instance is
// kept for ever.
[[maybe_unused]] Instance* const kept_instance = [] {
  auto made = Instance::create();
  return made ? std::move(*made).release() : nullptr;
}();
}  // namespace
}  // namespace maille::gpu

#elif defined(__SANITIZE_THREAD__)

// Without instrumented builds of them, their own ways of ordering threads are not seen. The
// validation layer's queue thread unlocks what the next call deletes.
extern "C" const char* __tsan_default_suppressions() {
  return "race:libVkLayer_khronos_validation\nrace:libvulkan_lvp\n";
}

#endif
