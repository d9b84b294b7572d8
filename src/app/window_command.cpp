#include <cstdio>

#include "app/commands.h"
#include "app/demo_scene.h"
#include "app/paths.h"
#include "app/window.h"

namespace maille {
namespace {

// "rendr": a command misspelt as likely as a file forgotten.
bool is_bare_word(const std::filesystem::path& input) {
  return !input.has_parent_path() && !input.has_extension();
}

}  // namespace

Result<void> run_window_command(const WindowCommandOptions& options, const GlobalOptions& global) {
  if (options.input.empty()) return run_window(built_in_scene(), global);
  std::error_code ignored;
  if (is_bare_word(options.input) && !std::filesystem::exists(options.input, ignored)) {
    return Error{ErrorKind::usage,
                 "unknown command or missing file: " + options.input.string() + " (maille --help)"};
  }
  auto scene = open_scene(options.input);
  if (!scene) return scene.error();
  if (const auto* const file = std::get_if<std::filesystem::path>(&scene->volume)) {
    if (auto checked = check_input(*file); !checked) return checked;
  }
  if (!scene->actions.empty() && !global.quiet) {
    std::fprintf(stderr,
                 "maille: note: the window opens the scene and leaves its actions to you; "
                 "maille render plays them\n");
  }
  return run_window(*std::move(scene), global);
}

}  // namespace maille
