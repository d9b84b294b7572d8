#include <cstdio>

#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "app/paths.h"
#include "app/sha256.h"
#include "volume/statistics.h"
#include "volume/volume_file.h"

namespace maille {
namespace {

using Json = nlohmann::ordered_json;

Json numbers(glm::dvec3 v) { return {v.x, v.y, v.z}; }

// Three rows of three numbers; the columns are the unit vectors along the volume's axes.
Json direction_of(const Volume& volume) {
  const auto spacing = volume.spacing_mm();
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row) {
    Json columns = Json::array();
    for (int axis = 0; axis < 3; ++axis) {
      columns.push_back(volume.world_from_voxel()[axis][row] / spacing[axis]);
    }
    rows.push_back(columns);
  }
  return rows;
}

std::string row_of(const Json& values) {
  std::string out;
  for (const auto& value : values) out += (out.empty() ? "" : " ") + value.dump();
  return out;
}

void print_line(const char* name, const std::string& text) {
  std::printf("%-13s %s\n", name, text.c_str());
}

void print_text(const Json& info) {
  print_line("size", row_of(info["size"]) + " voxels");
  print_line("type", info["type"].get<std::string>());
  print_line("spacing", row_of(info["spacing_mm"]) + " mm");
  print_line("origin", row_of(info["origin_mm"]) + " mm (LPS)");
  for (std::size_t row = 0; row < 3; ++row) {
    print_line(row == 0 ? "direction" : "", row_of(info["direction"][row]));
  }
  print_line("range", row_of(info["range"]));
  print_line("not finite", info["nan_count"].dump());
  print_line("voxel sha256", info["voxel_sha256"].get<std::string>());
}

}  // namespace

Result<void> run_info(const InfoOptions& options, const GlobalOptions&) {
  if (auto checked = check_input(options.file); !checked) return checked;
  const auto volume = read_volume(options.file);
  if (!volume) return volume.error();
  const auto statistics = statistics_of(*volume);
  const auto size = volume->size();
  const Json info = {{"size", {size.x, size.y, size.z}},
                     {"type", name_of(volume->type())},
                     {"spacing_mm", numbers(volume->spacing_mm())},
                     {"origin_mm", numbers(glm::dvec3(volume->world_from_voxel()[3]))},
                     {"direction", direction_of(*volume)},
                     {"range", {statistics.lowest, statistics.highest}},
                     {"nan_count", statistics.nan_count},
                     {"histogram", statistics.histogram},
                     {"voxel_sha256", sha256_hex(volume->bytes())}};
  if (options.json) {
    std::printf("%s\n", info.dump(2).c_str());
  } else {
    print_text(info);
  }
  return {};
}

}  // namespace maille
