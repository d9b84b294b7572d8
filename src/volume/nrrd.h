// NRRD ("nearly raw raster data", Teem's format, versions 1 to 5): a text header, an empty line and
// the samples (.nrrd), or a header naming a data file (.nhdr). Read: three axes, encodings raw and
// gzip. Read as a sentence of refusal: ascii, hex, bzip2, several data files, other dimensions.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "volume/volume.h"

namespace maille {

// The world is LPS whatever space the file states (RAS and LAS are turned); without a stated
// patient space its coordinates are taken as they are. `spacings` alone put voxel (0,0,0) at 0.
// Errors: as read_volume.
Result<Volume> read_nrrd(const std::filesystem::path& path);

// The header of an attached raw file, with the empty line that ends it, padded so that the samples
// start at a multiple of 64 bytes and can be mapped. Samples of type "float" with vector_length 3
// make a vector field, 0 a scalar volume.
std::string nrrd_header_text(Size3 size, VoxelType type, const glm::dmat4& world_from_voxel,
                             int vector_length);

}  // namespace maille
