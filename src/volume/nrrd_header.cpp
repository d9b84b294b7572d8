#include "volume/nrrd_header.h"

#include <algorithm>

namespace maille {
namespace {

constexpr std::string_view kFieldNames[] = {
    "dimension",
    "type",
    "blocksize",
    "encoding",
    "endian",
    "content",
    "min",
    "max",
    "oldmin",
    "oldmax",
    "datafile",
    "lineskip",
    "byteskip",
    "number",
    "sampleunits",
    "sizes",
    "spacings",
    "thicknesses",
    "axismins",
    "axismaxs",
    "centerings",
    "centers",
    "labels",
    "units",
    "kinds",
    "space",
    "spacedimension",
    "spaceunits",
    "spaceorigin",
    "spacedirections",
    "measurementframe",
};

}  // namespace

Result<NrrdHeader> parse_nrrd_header(const SamplePlace& place) {
  NrrdHeader header{place.path, place.file, {}, 0, 0};
  HeaderLines lines(place.file->bytes());
  const auto magic = lines.next().value_or(HeaderLine{1, ""});
  if (magic.text.size() != 8 || !magic.text.starts_with("NRRD000") || magic.text[7] < '1' ||
      magic.text[7] > '5') {
    return expected_at_line(place.path, 1, "NRRD0001 to NRRD0005", magic.text);
  }
  while (const auto line = lines.next()) {
    if (line->text.empty()) break;
    if (line->text[0] == '#') continue;
    const auto colon = line->text.find(':');
    if (colon == line->text.npos) {
      return expected_at_line(place.path, line->number, "\"field: value\" or \"key:=value\"",
                              line->text);
    }
    if (line->text.substr(colon).starts_with(":=")) continue;
    std::string name = lower_case(line->text.substr(0, colon));
    std::erase(name, ' ');
    if (std::ranges::find(kFieldNames, name) == std::end(kFieldNames)) {
      return expected_at_line(place.path, line->number, "a field that NRRD has", line->text);
    }
    const NrrdField field{line->number, trimmed(line->text.substr(colon + 1))};
    const bool lists_files = name == "datafile" && lower_case(field.text).starts_with("list");
    if (!header.fields.emplace(std::move(name), field).second) {
      return expected_at_line(place.path, line->number, "each field once", line->text);
    }
    if (lists_files) break;  // what follows are names, not fields
  }
  header.last_line = lines.line_number();
  header.end = lines.offset();
  return header;
}

}  // namespace maille
