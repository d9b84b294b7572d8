// Leaks that are not ours: what drivers and layers keep for the life of the process.
//
// Included by one file of each test program. The leak sanitizer can tell whose they are only while
// the libraries are loaded, so an instance is kept for ever.
#pragma once

#if defined(__SANITIZE_ADDRESS__)

#include "gpu/instance.h"

extern "C" const char* __lsan_default_suppressions() {
  return "leak:libvulkan\nleak:libVkLayer\nleak:libLLVM\nleak:libgallium\nleak:_dl_\n";
}

namespace maille::gpu {
inline Instance* const kept_instance = [] {
  auto made = Instance::create();
  return made ? std::move(*made).release() : nullptr;
}();
}  // namespace maille::gpu

#endif
