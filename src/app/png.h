// Pictures as PNG files.
#pragma once

#include <filesystem>

#include "core/result.h"
#include "render/renderer.h"

namespace maille {

// Written atomically, as RGB. Errors: file_system, out_of_memory.
Result<void> write_png(const std::filesystem::path& path, const Picture& picture);

}  // namespace maille
