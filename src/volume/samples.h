// The samples of a file as a Volume: mapped where they lie ready for use, decoded where not. Shared
// by the formats, which only find out what the samples are and where they start.
#pragma once

#include <bit>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/mapped_file.h"
#include "volume/volume.h"

namespace maille {

struct SampleFormat {
  Size3 size{0};
  VoxelType type = VoxelType::uint8;
  std::endian order = std::endian::native;
  glm::dmat4 world_from_voxel{1.0};
};

// A file and where in it the samples start.
struct SamplePlace {
  std::filesystem::path path;
  std::shared_ptr<const MappedFile> file;
  std::size_t offset = 0;

  std::size_t bytes_left() const { return file->bytes().size() - offset; }
};

inline constexpr std::string_view kSupportedTypes =
    "one of the supported sample types (8- or 16-bit integer, signed or unsigned, or 32-bit float)";

// Three words as sizes, or nothing unless each is an integer in 1 .. 2^31-1 and the samples take
// less than 2^63 bytes.
std::optional<Size3> sizes_of(const std::vector<std::string_view>& words, VoxelType type);

std::uint64_t sample_bytes(const SampleFormat& format);
std::string text_of(const SampleFormat& format);  // "512x512x333 int16"

// Whether the three axes (columns) span space, so that the matrix can be inverted.
bool is_invertible(const glm::dmat4& world_from_voxel);

// Errors: file_system.
Result<SamplePlace> open_samples(const std::filesystem::path& path);
// The data file that line of header names, relative to the header's folder. Errors: bad_input.
Result<SamplePlace> open_detached(const std::filesystem::path& header, int line,
                                  std::string_view name);

// Uncompressed samples at place. More bytes may follow them.
// Errors: bad_input (too few bytes).
Result<Volume> volume_of_raw(const SamplePlace& place, const SampleFormat& format);

// Samples in a gzip or zlib stream at place, behind skip decompressed bytes. Errors: bad_input.
Result<Volume> volume_of_deflated(const SamplePlace& place, std::uint64_t skip,
                                  const SampleFormat& format);

}  // namespace maille
