#include <cstdio>

#include "app/commands.h"

namespace maille {

Result<void> list_devices() {
  const auto instance = gpu::Instance::create();
  if (!instance) return instance.error();
  const auto devices = gpu::list_devices(*instance.value());
  if (!devices) return devices.error();
  for (const auto& device : *devices) {
    std::printf("%d  %s  (%s, %s%s)%s\n", device.index, device.name.c_str(),
                std::string(gpu::name_of(device.type)).c_str(), device.driver.c_str(),
                device.sparse ? ", sparse" : "",
                device.unusable.empty() ? "" : ("  unusable: " + device.unusable).c_str());
  }
  return {};
}

}  // namespace maille
