#include "volume/samples.h"

#include <cmath>
#include <cstring>
#include <limits>

#include "volume/header_lines.h"
#include "volume/inflate.h"

namespace maille {
namespace {

template <std::size_t N>
void reverse_each(std::span<std::byte> bytes) {
  for (std::size_t i = 0; i + N <= bytes.size(); i += N) {
    for (std::size_t j = 0; j < N / 2; ++j) std::swap(bytes[i + j], bytes[i + N - 1 - j]);
  }
}

void to_native_order(std::span<std::byte> bytes, const SampleFormat& format) {
  if (format.order == std::endian::native) return;
  const auto width = bytes_per_voxel(format.type);
  if (width == 2) reverse_each<2>(bytes);
  if (width == 4) reverse_each<4>(bytes);
}

// Memory that is not cleared first: a stream that turns out to be cut short then touches no more
// of it than it fills.
struct Buffer {
  explicit Buffer(std::size_t count)
      : memory(std::make_unique_for_overwrite<std::byte[]>(count)), size(count) {}
  std::span<std::byte> bytes() { return {memory.get(), size}; }

  std::unique_ptr<std::byte[]> memory;
  std::size_t size;
};

Volume volume_of(std::shared_ptr<Buffer> buffer, const SampleFormat& format) {
  to_native_order(buffer->bytes(), format);
  const auto bytes = buffer->bytes();
  return Volume(format.size, format.type, format.world_from_voxel, bytes, std::move(buffer));
}

}  // namespace

std::optional<Size3> sizes_of(const std::vector<std::string_view>& words, VoxelType type) {
  if (words.size() != 3) return std::nullopt;
  Size3 size{0};
  auto bytes = static_cast<std::int64_t>(bytes_per_voxel(type));
  for (int axis = 0; axis < 3; ++axis) {
    const auto extent = integer_of(words[static_cast<std::size_t>(axis)]);
    if (!extent || *extent < 1 || *extent > std::numeric_limits<int>::max()) return std::nullopt;
    if (__builtin_mul_overflow(bytes, *extent, &bytes)) return std::nullopt;
    size[axis] = static_cast<int>(*extent);
  }
  return size;
}

std::uint64_t sample_bytes(const SampleFormat& format) {
  return static_cast<std::uint64_t>(voxel_count(format.size)) * bytes_per_voxel(format.type);
}

std::string text_of(const SampleFormat& format) {
  return std::to_string(format.size.x) + "x" + std::to_string(format.size.y) + "x" +
         std::to_string(format.size.z) + " " + std::string(name_of(format.type));
}

bool is_invertible(const glm::dmat4& world_from_voxel) {
  const glm::dmat3 axes(world_from_voxel);
  const double lengths = glm::length(axes[0]) * glm::length(axes[1]) * glm::length(axes[2]);
  // Of unit axes the determinant is the volume they span: below this they lie in a plane.
  constexpr double kFlat = 1e-9;
  const double determinant = glm::determinant(axes);
  return std::isfinite(lengths) && std::isfinite(determinant) && lengths > 0 &&
         std::abs(determinant) > kFlat * lengths && std::isfinite(world_from_voxel[3].x) &&
         std::isfinite(world_from_voxel[3].y) && std::isfinite(world_from_voxel[3].z);
}

Result<SamplePlace> open_samples(const std::filesystem::path& path) {
  auto file = MappedFile::open(path);
  if (!file) return file.error();
  return SamplePlace{path, std::make_shared<const MappedFile>(*std::move(file)), 0};
}

Result<SamplePlace> open_detached(const std::filesystem::path& header, int line,
                                  std::string_view name) {
  auto place = open_samples(header.parent_path() / name);
  if (place) return place;
  return Error{ErrorKind::bad_input,
               header.string() + ":" + std::to_string(line) +
                   ": expected the data file that it names: " + place.error().message};
}

Result<Volume> volume_of_raw(const SamplePlace& place, const SampleFormat& format) {
  const auto wanted = sample_bytes(format);
  if (wanted > place.bytes_left()) {
    return expected_at_byte(place.path, place.offset,
                            std::to_string(wanted) + " bytes of samples (" + text_of(format) +
                                "), got " + std::to_string(place.bytes_left()));
  }
  const auto stored = place.file->bytes().subspan(place.offset, wanted);
  const auto width = bytes_per_voxel(format.type);
  const bool is_ready = (format.order == std::endian::native || width == 1) &&
                        reinterpret_cast<std::uintptr_t>(stored.data()) % width == 0;
  if (is_ready) {
    return Volume(format.size, format.type, format.world_from_voxel, stored, place.file);
  }
  auto buffer = std::make_shared<Buffer>(wanted);
  std::memcpy(buffer->bytes().data(), stored.data(), wanted);
  return volume_of(std::move(buffer), format);
}

Result<Volume> volume_of_deflated(const SamplePlace& place, std::uint64_t skip,
                                  const SampleFormat& format) {
  const auto wanted = sample_bytes(format);
  const std::uint64_t compressed = place.bytes_left();
  std::uint64_t most = 0, needed = 0;
  if (__builtin_mul_overflow(compressed, kDeflateLargestRatio, &most)) {
    most = std::numeric_limits<std::uint64_t>::max();
  }
  if (__builtin_add_overflow(skip, wanted, &needed) || needed > most) {
    return expected_at_byte(place.path, place.offset,
                            "compressed data that can hold " + std::to_string(wanted) +
                                " bytes of samples (" + text_of(format) + "), got " +
                                std::to_string(compressed) + " bytes, which hold at most " +
                                std::to_string(most));
  }
  auto buffer = std::make_shared<Buffer>(wanted);
  const auto stream = place.file->bytes().subspan(place.offset);
  auto filled = inflate_into(buffer->bytes(), skip, stream, place.path, place.offset);
  if (!filled) return filled.error();
  return volume_of(std::move(buffer), format);
}

}  // namespace maille
