// Volumes in files. The format is chosen by the ending (and checked against the content):
//   .nrrd .nhdr   NRRD, attached or detached data, raw or gzip
//   .mha .mhd     MetaImage, attached or detached data, raw or zlib
//   .raw          bare samples, dimensions and type in the name: NAME_XxYxZ_TYPE.raw
#pragma once

#include <filesystem>
#include <span>

#include "volume/volume.h"

namespace maille {

// Uncompressed samples in the machine's byte order are mapped, everything else is decoded into
// memory. Nothing is allocated that the file's own size does not vouch for.
// Errors: file_system (cannot be opened), bad_input (file, line or offset, what was expected).
Result<Volume> read_volume(const std::filesystem::path& path);

// Writes .nrrd or .mha atomically, samples uncompressed, orientation kept (LPS).
// Errors: usage (an ending that is not written), file_system.
Result<void> write_volume(const std::filesystem::path& path, const Volume& volume);

// A vector a voxel, three floats each, x fastest, as displacement fields are kept: NRRD (kinds:
// vector domain domain domain) or MetaImage (ElementNumberOfChannels = 3).
Result<void> write_vector_field(const std::filesystem::path& path, Size3 size,
                                const glm::dmat4& world_from_voxel,
                                std::span<const glm::vec3> vectors);

}  // namespace maille
