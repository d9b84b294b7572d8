// The desktop: a window in which a person turns a scan, grabs it and pulls.
#pragma once

#include "app/commands.h"
#include "app/scene.h"

namespace maille {

// Opens the scene and returns when the window is closed.
// Errors: device (no display, no usable device or it was lost), and whatever opening the scene
// meets.
Result<void> run_window(Scene scene, const GlobalOptions& global);

}  // namespace maille
