#include "app/scene.h"

#include <algorithm>
#include <cctype>

#include "core/mapped_file.h"

namespace maille {

std::string_view name_of(const Action& action) {
  static constexpr std::string_view kNames[] = {"drag", "relax", "render", "release", "undo",
                                                "redo", "save",  "cut",    "carve",   "restore"};
  static_assert(std::size(kNames) == std::variant_size_v<Action>);
  return kNames[action.index()];
}

std::optional<SavedExtent> saved_extent_named(std::string_view name) {
  if (name == "grow") return SavedExtent::grow;
  if (name == "keep") return SavedExtent::keep;
  return std::nullopt;
}

Result<Scene> open_scene(const std::filesystem::path& input) {
  auto ending = input.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (ending != ".json") {
    Scene scene;
    scene.volume = input;
    return scene;
  }
  const auto file = MappedFile::open(input);
  if (!file) return file.error();
  const auto bytes = file->bytes();
  return parse_scene({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, input);
}

}  // namespace maille
