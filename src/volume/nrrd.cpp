#include "volume/nrrd.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "volume/header_lines.h"
#include "volume/nrrd_header.h"
#include "volume/samples.h"

namespace maille {
namespace {

constexpr std::pair<std::string_view, VoxelType> kTypeNames[] = {
    {"signed char", VoxelType::int8},
    {"int8", VoxelType::int8},
    {"int8_t", VoxelType::int8},
    {"uchar", VoxelType::uint8},
    {"unsigned char", VoxelType::uint8},
    {"uint8", VoxelType::uint8},
    {"uint8_t", VoxelType::uint8},
    {"short", VoxelType::int16},
    {"short int", VoxelType::int16},
    {"signed short", VoxelType::int16},
    {"signed short int", VoxelType::int16},
    {"int16", VoxelType::int16},
    {"int16_t", VoxelType::int16},
    {"ushort", VoxelType::uint16},
    {"unsigned short", VoxelType::uint16},
    {"unsigned short int", VoxelType::uint16},
    {"uint16", VoxelType::uint16},
    {"uint16_t", VoxelType::uint16},
    {"float", VoxelType::float32},
};

Result<VoxelType> type_of(const NrrdHeader& header) {
  const auto field = header.find("type");
  if (!field) return header.missing("the field \"type\"");
  for (const auto& [name, type] : kTypeNames) {
    if (lower_case(field->text) == name) return type;
  }
  return header.expected(*field, kSupportedTypes);
}

Result<Size3> size_of(const NrrdHeader& header, VoxelType type) {
  const auto dimension = header.find("dimension");
  if (!dimension) return header.missing("the field \"dimension\"");
  if (integer_of(dimension->text) != 3) {
    return header.expected(*dimension, "3 dimensions (only scalar volumes are read)");
  }
  const auto sizes = header.find("sizes");
  if (!sizes) return header.missing("the field \"sizes\"");
  const auto size = sizes_of(words_of(sizes->text), type);
  if (!size) return header.expected(*sizes, "three sizes >= 1 that memory can hold");
  if (const auto kinds = header.find("kinds")) {
    for (const auto kind : words_of(kinds->text)) {
      const auto name = lower_case(kind);
      if (name != "domain" && name != "space" && name != "???" && name != "none") {
        return header.expected(*kinds, "three spatial axes (kinds \"domain\" or \"space\")");
      }
    }
  }
  return *size;
}

Result<std::endian> order_of(const NrrdHeader& header, VoxelType type) {
  const auto field = header.find("endian");
  if (!field) {
    if (bytes_per_voxel(type) == 1) return std::endian::native;
    return header.missing("the field \"endian\" (samples have several bytes)");
  }
  const auto name = lower_case(field->text);
  if (name == "little") return std::endian::little;
  if (name == "big") return std::endian::big;
  return header.expected(*field, "\"little\" or \"big\"");
}

// Factors that turn the file's space into LPS.
Result<glm::dvec3> lps_from_space(const NrrdHeader& header) {
  if (const auto count = header.find("spacedimension"); count && integer_of(count->text) != 3) {
    return header.expected(*count, "a space of 3 dimensions");
  }
  const auto field = header.find("space");
  if (!field) return glm::dvec3(1, 1, 1);
  const auto name = lower_case(field->text);
  if (name == "left-posterior-superior" || name == "lps") return glm::dvec3(1, 1, 1);
  if (name == "right-anterior-superior" || name == "ras") return glm::dvec3(-1, -1, 1);
  if (name == "left-anterior-superior" || name == "las") return glm::dvec3(1, -1, 1);
  if (name == "scanner-xyz" || name == "3d-right-handed" || name == "3d-left-handed") {
    return glm::dvec3(1, 1, 1);
  }
  return header.expected(*field,
                         "a space of 3 dimensions (left-posterior-superior, "
                         "right-anterior-superior, left-anterior-superior, scanner-xyz, "
                         "3D-right-handed or 3D-left-handed)");
}

// count vectors as "(x,y,z) (x,y,z) …", or nothing; spaces may stand anywhere but inside a number.
std::optional<std::vector<glm::dvec3>> vectors_of(std::string_view text, std::size_t count) {
  std::vector<glm::dvec3> vectors;
  for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
    const auto close = text.find(')');
    if (text[0] != '(' || close == text.npos || vectors.size() == count) return std::nullopt;
    std::string inside(text.substr(1, close - 1));
    if (std::count(inside.begin(), inside.end(), ',') != 2) return std::nullopt;
    std::replace(inside.begin(), inside.end(), ',', ' ');
    const auto numbers = finite_numbers_of(inside, 3);
    if (!numbers) return std::nullopt;
    vectors.emplace_back((*numbers)[0], (*numbers)[1], (*numbers)[2]);
    text.remove_prefix(close + 1);
  }
  if (vectors.size() != count) return std::nullopt;
  return vectors;
}

Result<glm::dmat4> world_from_voxel_of(const NrrdHeader& header) {
  const auto lps = lps_from_space(header);
  if (!lps) return lps.error();
  glm::dmat4 world(1.0);
  const auto directions = header.find("spacedirections");
  const auto spacings = header.find("spacings");
  if (directions) {
    const auto axes = vectors_of(directions->text, 3);
    if (!axes) return header.expected(*directions, "three vectors \"(x,y,z)\" of finite numbers");
    for (int axis = 0; axis < 3; ++axis) {
      world[axis] = glm::dvec4((*axes)[static_cast<std::size_t>(axis)] * *lps, 0.0);
    }
    if (!is_invertible(world)) {
      return header.expected(*directions, "three axes that span space (not singular)");
    }
  } else if (spacings) {
    const auto steps = finite_numbers_of(spacings->text, 3);
    if (steps) world = axis_aligned({(*steps)[0], (*steps)[1], (*steps)[2]});
    if (!steps || !is_invertible(world)) {
      return header.expected(*spacings, "three finite spacings that are not 0");
    }
    for (int axis = 0; axis < 3; ++axis) world[axis] *= glm::dvec4(*lps, 0.0);
  }
  if (const auto origin = header.find("spaceorigin")) {
    const auto point = vectors_of(origin->text, 1);
    if (!point) return header.expected(*origin, "a point \"(x,y,z)\" of finite numbers");
    world[3] = glm::dvec4(point->front() * *lps, 1.0);
  }
  return world;
}

// Where the data are: in the header's own file after it, or in the one that it names.
Result<SamplePlace> data_of(const NrrdHeader& header, SamplePlace own) {
  const auto field = header.find("datafile");
  if (!field) {
    own.offset = header.end;
    if (lower_case(header.path.extension().string()) == ".nhdr") {
      return header.missing("the field \"data file\"");
    }
    return own;
  }
  const auto words = words_of(field->text);
  if (words.empty() || lower_case(words[0]) == "list" ||
      (words.size() > 3 && field->text.find('%') != field->text.npos)) {
    return header.expected(*field, "one data file (several files are not read yet)");
  }
  return open_detached(header.path, field->line, field->text);
}

Result<void> skip_lines(const NrrdHeader& header, SamplePlace& place) {
  const auto field = header.find("lineskip");
  if (!field) return {};
  const auto count = integer_of(field->text);
  if (!count || *count < 0) return header.expected(*field, "a number of lines >= 0");
  const auto bytes = place.file->bytes();
  for (std::int64_t line = 0; line < *count; ++line) {
    const auto end = std::find(bytes.begin() + static_cast<std::ptrdiff_t>(place.offset),
                               bytes.end(), std::byte{'\n'});
    if (end == bytes.end()) {
      return header.expected(*field, "no more lines to skip than the data file has");
    }
    place.offset = static_cast<std::size_t>(end - bytes.begin()) + 1;
  }
  return {};
}

Result<Volume> read_raw(const NrrdHeader& header, SamplePlace place, const SampleFormat& format) {
  if (const auto skip = header.find("byteskip")) {
    const auto count = integer_of(skip->text);
    if (!count || *count < -1) return header.expected(*skip, "a number of bytes >= -1");
    const auto wanted = sample_bytes(format);
    if (*count == -1 && wanted <= place.bytes_left()) {
      place.offset += place.bytes_left() - wanted;
    } else if (*count > 0) {
      if (static_cast<std::uint64_t>(*count) > place.bytes_left()) {
        return header.expected(*skip, "no more bytes to skip than the data file has");
      }
      place.offset += static_cast<std::size_t>(*count);
    }
  }
  return volume_of_raw(place, format);
}

Result<Volume> read_gzip(const NrrdHeader& header, const SamplePlace& place,
                         const SampleFormat& format) {
  std::int64_t count = 0;
  if (const auto skip = header.find("byteskip")) {
    count = integer_of(skip->text).value_or(-1);
    if (count < 0) return header.expected(*skip, "a number of bytes >= 0 (the data are gzip)");
  }
  return volume_of_deflated(place, static_cast<std::uint64_t>(count), format);
}

std::string vector_text(glm::dvec3 v) {
  return "(" + text_of(v.x) + "," + text_of(v.y) + "," + text_of(v.z) + ")";
}

}  // namespace

Result<Volume> read_nrrd(const std::filesystem::path& path) {
  auto own = open_samples(path);
  if (!own) return own.error();
  const auto header = parse_nrrd_header(*own);
  if (!header) return header.error();
  SampleFormat format;
  const auto type = type_of(*header);
  if (!type) return type.error();
  const auto size = size_of(*header, *type);
  if (!size) return size.error();
  const auto encoding = header->find("encoding");
  if (!encoding) return header->missing("the field \"encoding\"");
  const auto encoding_name = lower_case(encoding->text);
  if (encoding_name != "raw" && encoding_name != "gzip" && encoding_name != "gz") {
    return header->expected(*encoding, "encoding raw or gzip");
  }
  const auto order = order_of(*header, *type);
  if (!order) return order.error();
  const auto world = world_from_voxel_of(*header);
  if (!world) return world.error();
  format = {*size, *type, *order, *world};

  auto place = data_of(*header, *std::move(own));
  if (!place) return place.error();
  if (auto skipped = skip_lines(*header, *place); !skipped) return skipped.error();
  if (encoding_name == "raw") return read_raw(*header, *place, format);
  return read_gzip(*header, *place, format);
}

std::string nrrd_header_text(Size3 size, VoxelType type, const glm::dmat4& world_from_voxel,
                             int vector_length) {
  const bool is_field = vector_length > 0;
  const auto sizes =
      std::to_string(size.x) + " " + std::to_string(size.y) + " " + std::to_string(size.z);
  std::string text = "NRRD0004\n";
  text += "type: " + std::string(type == VoxelType::float32 ? "float" : name_of(type)) + "\n";
  text += "dimension: " + std::string(is_field ? "4" : "3") + "\n";
  text += "space: left-posterior-superior\n";
  text += "sizes: " + (is_field ? std::to_string(vector_length) + " " : "") + sizes + "\n";
  text += std::string("space directions:") + (is_field ? " none" : "");
  for (int axis = 0; axis < 3; ++axis) text += " " + vector_text(world_from_voxel[axis]);
  text += std::string("\nkinds: ") + (is_field ? "vector " : "") + "domain domain domain\n";
  text += std::string("endian: ") + (std::endian::native == std::endian::big ? "big" : "little");
  text += "\nencoding: raw\n";
  text += "space origin: " + vector_text(world_from_voxel[3]) + "\n";
  constexpr std::size_t kAlignment = 64;
  const std::size_t length = text.size() + 3;  // with "#", its line end and the empty line
  return text + "#" + std::string((kAlignment - length % kAlignment) % kAlignment, ' ') + "\n\n";
}

}  // namespace maille
