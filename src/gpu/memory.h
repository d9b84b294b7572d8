// Device memory, chosen by what it is for.
#pragma once

#include <cstdint>
#include <string_view>

#include "gpu/device.h"

namespace maille::gpu {

enum class MemoryUse {
  device,    // the GPU reads and writes it, the CPU never does
  upload,    // the CPU writes it once and never reads: coherent, write-combined is welcome
  staging,   // the CPU writes it, and reads that again: cached if there is
  readback,  // the GPU writes it, the CPU reads it: cached, else reading is 50 times slower
};

// The type among type_bits that serves best. Errors: device (no type serves at all).
Result<std::uint32_t> memory_type_for(const Device& device, std::uint32_t type_bits, MemoryUse use);

// what names the memory in errors and in validation messages.
Result<OwnedMemory> allocate(const Device& device, const VkMemoryRequirements& needs, MemoryUse use,
                             std::string_view what);

}  // namespace maille::gpu
