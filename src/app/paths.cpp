#include "app/paths.h"

#include <algorithm>
#include <cctype>

namespace maille {
namespace {

bool ends_in(const std::filesystem::path& path, std::initializer_list<std::string_view> endings) {
  auto ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(endings.begin(), endings.end(), ending) != endings.end();
}

Result<void> check_file(const std::string& place, const std::filesystem::path& path) {
  std::error_code ignored;
  const auto refuse = [&](const std::string& why) {
    return Error{ErrorKind::file_system, place + ": " + path.string() + ": " + why};
  };
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  if (!std::filesystem::is_directory(folder, ignored)) {
    return refuse("there is no folder " + folder.string());
  }
  if (std::filesystem::is_directory(path, ignored)) return refuse("a folder of that name is there");
  return {};
}

Result<void> check_folder(const std::string& place, const std::filesystem::path& path) {
  std::error_code ignored;
  auto nearest = std::filesystem::absolute(path).lexically_normal();
  while (!std::filesystem::exists(nearest, ignored) && nearest.has_relative_path()) {
    nearest = nearest.parent_path();
  }
  if (std::filesystem::is_directory(nearest, ignored)) return {};
  return Error{ErrorKind::file_system,
               place + ": " + path.string() + ": " + nearest.string() + " is no folder"};
}

Result<void> check_output(const Output& output) {
  const std::string option(output.option);
  const auto expected = [&](std::string_view name) {
    return Error{ErrorKind::usage, option + ": expected " + std::string(name) + ", got " +
                                       output.path.filename().string()};
  };
  if (output.kind == OutputKind::volume && !is_volume_name(output.path)) {
    return expected(kVolumeName);
  }
  if (output.kind == OutputKind::picture && !is_picture_name(output.path)) {
    return expected(kPictureName);
  }
  return output.kind == OutputKind::folder ? check_folder(option, output.path)
                                           : check_file(option, output.path);
}

}  // namespace

bool is_volume_name(const std::filesystem::path& path) { return ends_in(path, {".nrrd", ".mha"}); }

bool is_picture_name(const std::filesystem::path& path) { return ends_in(path, {".png"}); }

Result<void> check_outputs(std::initializer_list<Output> outputs) {
  for (const Output& output : outputs) {
    if (output.path.empty()) continue;
    if (auto checked = check_output(output); !checked) return checked;
  }
  return {};
}

Result<void> check_action_outputs(const Scene& scene, bool pictures) {
  for (std::size_t i = 0; i < scene.actions.size(); ++i) {
    const auto check = [&](std::string_view key, const std::filesystem::path& path) {
      return check_file(
          scene.file.string() + ": actions[" + std::to_string(i) + "]." + std::string(key), path);
    };
    Result<void> checked;
    if (const auto* const render = std::get_if<RenderAction>(&scene.actions[i])) {
      if (pictures) checked = check("render.to", render->to);
    } else if (const auto* const save = std::get_if<SaveAction>(&scene.actions[i])) {
      if (save->volume) checked = check("save.volume", *save->volume);
      if (checked && save->field) checked = check("save.field", *save->field);
    }
    if (!checked) return checked;
  }
  return {};
}

Result<void> check_input(const std::filesystem::path& path) {
  std::error_code ignored;
  const auto refuse = [&](const char* why) {
    return Error{ErrorKind::file_system, path.string() + ": " + why};
  };
  if (!std::filesystem::exists(path, ignored)) return refuse("no such file");
  if (std::filesystem::is_directory(path, ignored)) return refuse("expected a file, got a folder");
  return {};
}

}  // namespace maille
