// MetaImage, ITK's own format: "Key = Value" lines, the last of which says where the samples are:
// in the same file (.mha) or in another (.mhd), raw or as a zlib stream.
#pragma once

#include <filesystem>
#include <string>

#include "volume/volume.h"

namespace maille {

// As ITK reads it: each row of TransformMatrix is the direction of one axis of the volume, in LPS
// (so the file's matrix is the transpose of ITK's direction matrix), and Offset is the position of
// voxel (0,0,0). AnatomicalOrientation only comments on that and is not used.
// Errors: as read_volume.
Result<Volume> read_metaimage(const std::filesystem::path& path);

// The header of a file with LOCAL raw samples, padded so that they start at a multiple of 64 bytes
// and can be mapped. channels: samples a voxel.
std::string metaimage_header_text(Size3 size, VoxelType type, const glm::dmat4& world_from_voxel,
                                  int channels);

}  // namespace maille
