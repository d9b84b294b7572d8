// Where things come from and where they go, looked at before any work: a wrong name is no reason to
// find out after an hour.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>

#include "app/scene.h"
#include "core/result.h"

namespace maille {

// What a written file's name must end in, for messages; whatever the letters' case.
inline constexpr std::string_view kVolumeName = "a name ending in .nrrd or .mha";
inline constexpr std::string_view kPictureName = "a name ending in .png";
bool is_volume_name(const std::filesystem::path& path);
bool is_picture_name(const std::filesystem::path& path);

enum class OutputKind {
  volume,
  picture,
  text,    // of any name
  folder,  // made where it is missing, with those above it
};

struct Output {
  OutputKind kind;
  std::string_view option;     // that names it, for messages
  std::filesystem::path path;  // empty: not asked for
};

// Errors: usage (a wrong ending), file_system (the folder of a file is missing, or a folder lies
// where a file should go, or a file where a folder should).
Result<void> check_outputs(std::initializer_list<Output> outputs);
// The same for what a scene's actions write; pictures: its render actions are not skipped. Endings
// were parse_scene's business. Errors: file_system, with the key's path.
Result<void> check_action_outputs(const Scene& scene, bool pictures);

// Errors: file_system, unless it is a file that is there.
Result<void> check_input(const std::filesystem::path& path);

}  // namespace maille
