#include "volume/raw_file.h"

#include <optional>
#include <utility>

#include "volume/header_lines.h"
#include "volume/samples.h"

namespace maille {
namespace {

constexpr std::pair<std::string_view, VoxelType> kTypeNames[] = {
    {"uint8", VoxelType::uint8}, {"u8", VoxelType::uint8},      {"int8", VoxelType::int8},
    {"i8", VoxelType::int8},     {"uint16", VoxelType::uint16}, {"u16", VoxelType::uint16},
    {"int16", VoxelType::int16}, {"i16", VoxelType::int16},     {"float32", VoxelType::float32},
    {"f32", VoxelType::float32},
};

std::optional<SampleFormat> format_of(std::string_view stem) {
  const auto type_at = stem.rfind('_');
  if (type_at == stem.npos || type_at == 0) return std::nullopt;
  const auto size_at = stem.rfind('_', type_at - 1);
  if (size_at == stem.npos) return std::nullopt;
  std::string sizes = lower_case(stem.substr(size_at + 1, type_at - size_at - 1));
  if (sizes.find_first_not_of("0123456789x") != sizes.npos) return std::nullopt;
  for (char& c : sizes) c = c == 'x' ? ' ' : c;
  for (const auto& [name, type] : kTypeNames) {
    if (lower_case(stem.substr(type_at + 1)) != name) continue;
    const auto size = sizes_of(words_of(sizes), type);
    if (!size) return std::nullopt;
    return SampleFormat{*size, type, std::endian::little, glm::dmat4(1.0)};
  }
  return std::nullopt;
}

}  // namespace

Result<Volume> read_raw_file(const std::filesystem::path& path) {
  const auto place = open_samples(path);
  if (!place) return place.error();
  const auto format = format_of(path.stem().string());
  if (!format) {
    return Error{ErrorKind::bad_input,
                 path.string() +
                     ": expected a name that says what is in the file, NAME_XxYxZ_TYPE.raw, with "
                     "sizes >= 1 and TYPE uint8, int8, uint16, int16 or float32"};
  }
  const auto wanted = sample_bytes(*format);
  if (place->bytes_left() != wanted) {
    return Error{ErrorKind::bad_input, path.string() + ": expected exactly " +
                                           std::to_string(wanted) + " bytes (" + text_of(*format) +
                                           ", from its name), got " +
                                           std::to_string(place->bytes_left())};
  }
  return volume_of_raw(*place, *format);
}

}  // namespace maille
