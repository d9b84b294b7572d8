// The text part of an NRRD file as fields with their lines.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "volume/header_lines.h"
#include "volume/samples.h"

namespace maille {

struct NrrdField {
  int line = 0;
  std::string_view text;
};

struct NrrdHeader {
  std::filesystem::path path;
  std::shared_ptr<const MappedFile> file;                // holds what the texts point to
  std::map<std::string, NrrdField, std::less<>> fields;  // lower case, without spaces
  int last_line = 0;
  std::size_t end = 0;  // offset of the first byte after it

  std::optional<NrrdField> find(std::string_view name) const {
    const auto found = fields.find(name);
    return found == fields.end() ? std::nullopt : std::optional(found->second);
  }
  Error expected(const NrrdField& field, std::string_view what) const {
    return expected_at_line(path, field.line, what, field.text);
  }
  Error missing(std::string_view what) const {
    return expected_at_line(path, last_line, what, "the end of the header");
  }
};

// Everything up to the empty line or the end of the file. Comments and key/value pairs are dropped.
// Errors: bad_input (no NRRD of version 1 to 5, a line that is neither, an unknown field, one given
// twice).
Result<NrrdHeader> parse_nrrd_header(const SamplePlace& place);

}  // namespace maille
