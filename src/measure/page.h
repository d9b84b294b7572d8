// A measurement as a person and a program want it: JSON, CSV and SVG in a folder, and a table to
// read at once.
#pragma once

#include <filesystem>
#include <string>

#include "core/result.h"

namespace maille {

struct MeasurePage {
  std::string json;
  std::string csv;
  std::string svg;
  std::string table;  // for standard output
};

// Makes the folder, with those above it, and sees that files can be made in it: to be called before
// minutes of work. Errors: file_system.
Result<void> prepare_folder(const std::filesystem::path& folder);

// NAME.json, NAME.csv and NAME.svg. Errors: file_system.
Result<void> write_page(const MeasurePage& page, const std::filesystem::path& folder,
                        const std::string& name);

}  // namespace maille
