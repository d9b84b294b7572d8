#include "volume/metaimage.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "volume/header_lines.h"
#include "volume/samples.h"

namespace maille {
namespace {

constexpr std::pair<std::string_view, VoxelType> kTypeNames[] = {
    {"MET_UCHAR", VoxelType::uint8},   {"MET_CHAR", VoxelType::int8},
    {"MET_USHORT", VoxelType::uint16}, {"MET_SHORT", VoxelType::int16},
    {"MET_FLOAT", VoxelType::float32},
};

// The keys that mean something here, with their older spellings; any other key is a comment.
constexpr std::pair<std::string_view, std::string_view> kKeyNames[] = {
    {"ObjectType", "ObjectType"},
    {"NDims", "NDims"},
    {"DimSize", "DimSize"},
    {"BinaryData", "BinaryData"},
    {"BinaryDataByteOrderMSB", "ElementByteOrderMSB"},
    {"ElementByteOrderMSB", "ElementByteOrderMSB"},
    {"CompressedData", "CompressedData"},
    {"CompressedDataSize", "CompressedDataSize"},
    {"TransformMatrix", "TransformMatrix"},
    {"Orientation", "TransformMatrix"},
    {"Rotation", "TransformMatrix"},
    {"Offset", "Offset"},
    {"Position", "Offset"},
    {"Origin", "Offset"},
    {"ElementSpacing", "ElementSpacing"},
    {"ElementSize", "ElementSize"},
    {"ElementType", "ElementType"},
    {"ElementNumberOfChannels", "ElementNumberOfChannels"},
    {"HeaderSize", "HeaderSize"},
    {"ElementDataFile", "ElementDataFile"},
};

struct Value {
  int line = 0;
  std::string_view text;
};

struct Header {
  std::filesystem::path path;
  std::shared_ptr<const MappedFile> file;  // holds what the texts point to
  std::map<std::string_view, Value> values;
  int last_line = 0;
  std::size_t end = 0;  // offset of the first byte after it

  std::optional<Value> find(std::string_view key) const {
    const auto found = values.find(key);
    return found == values.end() ? std::nullopt : std::optional(found->second);
  }
  Error expected(const Value& value, std::string_view what) const {
    return expected_at_line(path, value.line, what, value.text);
  }
  Error missing(std::string_view key) const {
    return expected_at_line(path, last_line, "the key \"" + std::string(key) + "\"",
                            "the end of the header");
  }
};

Result<Header> parse_header(const SamplePlace& place) {
  Header header{place.path, place.file, {}, 1, 0};
  HeaderLines lines(place.file->bytes());
  while (const auto line = lines.next()) {
    header.last_line = line->number;
    if (line->text.empty() && line->number > 1) continue;
    const auto equals = line->text.find('=');
    const auto key = trimmed(line->text.substr(0, equals));
    if (equals == line->text.npos || key.empty()) {
      return expected_at_line(place.path, line->number, "\"Key = Value\" of a MetaImage header",
                              line->text);
    }
    for (const auto& [spelling, name] : kKeyNames) {
      if (key != spelling) continue;
      const Value value{line->number, trimmed(line->text.substr(equals + 1))};
      if (!header.values.emplace(name, value).second) {
        return expected_at_line(place.path, line->number, "each key once", line->text);
      }
    }
    if (key == "ElementDataFile") break;  // the samples may follow at once
  }
  header.end = lines.offset();
  if (header.values.empty()) {
    return expected_at_line(place.path, 1, "a MetaImage header", "no key of one");
  }
  return header;
}

Result<bool> flag(const Header& header, std::string_view key, bool if_absent) {
  const auto value = header.find(key);
  if (!value) return if_absent;
  const auto word = lower_case(value->text);
  if (word == "true" || word == "t" || word == "1") return true;
  if (word == "false" || word == "f" || word == "0") return false;
  return header.expected(*value, "True or False");
}

Result<VoxelType> type_of(const Header& header) {
  const auto value = header.find("ElementType");
  if (!value) return header.missing("ElementType");
  for (const auto& [name, type] : kTypeNames) {
    if (value->text == name) return type;
  }
  return header.expected(*value, kSupportedTypes);
}

Result<Size3> size_of(const Header& header, VoxelType type) {
  if (const auto object = header.find("ObjectType"); object && object->text != "Image") {
    return header.expected(*object, "Image");
  }
  const auto dimension = header.find("NDims");
  if (!dimension) return header.missing("NDims");
  if (integer_of(dimension->text) != 3) {
    return header.expected(*dimension, "3 dimensions (only scalar volumes are read)");
  }
  const auto channels = header.find("ElementNumberOfChannels");
  if (channels && integer_of(channels->text) != 1) {
    return header.expected(*channels, "1 channel (only scalar volumes are read)");
  }
  const auto sizes = header.find("DimSize");
  if (!sizes) return header.missing("DimSize");
  const auto size = sizes_of(words_of(sizes->text), type);
  if (!size) return header.expected(*sizes, "three sizes >= 1 that memory can hold");
  return *size;
}

Result<glm::dmat4> world_from_voxel_of(const Header& header) {
  glm::dmat4 world(1.0);
  if (const auto matrix = header.find("TransformMatrix")) {
    const auto rows = finite_numbers_of(matrix->text, 9);
    if (!rows) return header.expected(*matrix, "nine finite numbers");
    for (int i = 0; i < 9; ++i) world[i / 3][i % 3] = (*rows)[static_cast<std::size_t>(i)];
    if (!is_invertible(world)) {
      return header.expected(*matrix, "three axes that span space (not singular)");
    }
  }
  auto spacing = header.find("ElementSpacing");
  if (!spacing) spacing = header.find("ElementSize");
  if (spacing) {
    const auto steps = finite_numbers_of(spacing->text, 3);
    if (!steps || *std::min_element(steps->begin(), steps->end()) <= 0) {
      return header.expected(*spacing, "three finite spacings > 0");
    }
    for (int axis = 0; axis < 3; ++axis) world[axis] *= (*steps)[static_cast<std::size_t>(axis)];
    if (!is_invertible(world)) return header.expected(*spacing, "spacings that numbers can hold");
  }
  if (const auto offset = header.find("Offset")) {
    const auto point = finite_numbers_of(offset->text, 3);
    if (!point) return header.expected(*offset, "three finite numbers");
    world[3] = glm::dvec4((*point)[0], (*point)[1], (*point)[2], 1.0);
  }
  return world;
}

struct Data {
  SamplePlace place;
  bool is_compressed = false;
};

// Where the data are, HeaderSize applied: bytes from the start of the file that holds them, or -1
// for "the last bytes of it".
Result<Data> data_of(const Header& header, SamplePlace own, const SampleFormat& format) {
  const auto compressed = flag(header, "CompressedData", false);
  if (!compressed) return compressed.error();
  const auto name = header.find("ElementDataFile");
  if (!name || name->text.empty()) return header.missing("ElementDataFile");
  const auto words = words_of(name->text);
  if (words[0] == "LIST" || name->text.find('%') != name->text.npos) {
    return header.expected(*name, "LOCAL or one data file (several files are not read yet)");
  }
  Data data{std::move(own), *compressed};
  std::size_t earliest = header.end;
  if (lower_case(name->text) != "local") {
    auto detached = open_detached(header.path, name->line, name->text);
    if (!detached) return detached.error();
    data.place = *std::move(detached);
    earliest = 0;
  }
  data.place.offset = earliest;
  const auto skip = header.find("HeaderSize");
  if (!skip) return data;
  const auto count = integer_of(skip->text);
  const std::uint64_t file_size = data.place.file->bytes().size();
  if (!count || *count < -1 || (*count == -1 && *compressed) ||
      (*count > 0 && static_cast<std::uint64_t>(*count) < earliest) ||
      (*count > 0 && static_cast<std::uint64_t>(*count) > file_size)) {
    return header.expected(*skip, "a number of bytes before the samples, within the data file");
  }
  if (*count > 0) data.place.offset = static_cast<std::size_t>(*count);
  if (*count == -1 && sample_bytes(format) <= data.place.bytes_left()) {
    data.place.offset += data.place.bytes_left() - sample_bytes(format);
  }
  return data;
}

}  // namespace

Result<Volume> read_metaimage(const std::filesystem::path& path) {
  auto own = open_samples(path);
  if (!own) return own.error();
  const auto header = parse_header(*own);
  if (!header) return header.error();
  const auto binary = flag(*header, "BinaryData", true);
  if (!binary) return binary.error();
  if (!*binary) {
    return header->expected(*header->find("BinaryData"), "binary data (text is not read)");
  }
  const auto type = type_of(*header);
  if (!type) return type.error();
  const auto size = size_of(*header, *type);
  if (!size) return size.error();
  const auto is_big = flag(*header, "ElementByteOrderMSB", std::endian::native == std::endian::big);
  if (!is_big) return is_big.error();
  const auto world = world_from_voxel_of(*header);
  if (!world) return world.error();
  const SampleFormat format{*size, *type, *is_big ? std::endian::big : std::endian::little, *world};

  const auto data = data_of(*header, *std::move(own), format);
  if (!data) return data.error();
  if (!data->is_compressed) return volume_of_raw(data->place, format);
  const auto length = header->find("CompressedDataSize");
  if (length) {
    const auto count = integer_of(length->text);
    if (!count || *count < 0 || static_cast<std::uint64_t>(*count) > data->place.bytes_left()) {
      return header->expected(*length, "no more compressed bytes than the " +
                                           std::to_string(data->place.bytes_left()) +
                                           " that the file has");
    }
  }
  return volume_of_deflated(data->place, 0, format);
}

std::string metaimage_header_text(Size3 size, VoxelType type, const glm::dmat4& world_from_voxel,
                                  int channels) {
  std::string spacings, rows, offset, sizes;
  for (int axis = 0; axis < 3; ++axis) {
    const glm::dvec3 column(world_from_voxel[axis]);
    const double spacing = glm::length(column);
    spacings += " " + text_of(spacing);
    for (int i = 0; i < 3; ++i) rows += " " + text_of(column[i] / spacing + 0.0);
    offset += " " + text_of(world_from_voxel[3][axis]);
    sizes += " " + std::to_string(size[axis]);
  }
  std::string text = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = ";
  text += std::endian::native == std::endian::big ? "True\n" : "False\n";
  text += "CompressedData = False\nTransformMatrix =" + rows + "\nOffset =" + offset + "\n";
  text += "ElementSpacing =" + spacings + "\nDimSize =" + sizes + "\n";
  if (channels != 1) text += "ElementNumberOfChannels = " + std::to_string(channels) + "\n";
  for (const auto& [name, value] : kTypeNames) {
    if (value == type) text += "ElementType = " + std::string(name) + "\n";
  }
  constexpr std::string_view kLast = "ElementDataFile = LOCAL\n";
  constexpr std::string_view kComment = "Comment = padding";
  constexpr std::size_t kAlignment = 64;
  const std::size_t length = text.size() + kComment.size() + 1 + kLast.size();
  const std::string padding((kAlignment - length % kAlignment) % kAlignment, '.');
  return text + std::string(kComment) + padding + "\n" + std::string(kLast);
}

}  // namespace maille
