// Bare samples, little endian, x fastest; what they are stands in the name: NAME_XxYxZ_TYPE.raw
// with TYPE uint8, int8, uint16, int16 or float32 (or u8, i8, u16, i16, f32). The file says nothing
// of spacing: voxels are 1 mm and voxel (0,0,0) is at 0.
#pragma once

#include <filesystem>

#include "volume/volume.h"

namespace maille {

// Errors: as read_volume. The file's size must be exactly what its name promises.
Result<Volume> read_raw_file(const std::filesystem::path& path);

}  // namespace maille
