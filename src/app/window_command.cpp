#include "app/commands.h"
#include "app/demo_scene.h"
#include "app/window.h"

namespace maille {

Result<void> run_window_command(const WindowCommandOptions& options, const GlobalOptions& global) {
  auto scene = options.input.empty() ? Result<Scene>(built_in_scene()) : open_scene(options.input);
  if (!scene) return scene.error();
  return run_window(*std::move(scene), global);
}

}  // namespace maille
