// From the command line's words to what the parts of a run take.
#pragma once

#include <string>

#include "app/commands.h"
#include "app/headless.h"

namespace maille {

HeadlessOptions headless_options(const std::string& command, const GlobalOptions& global);
ViewOptions view_options(PictureSize size, const GlobalOptions& global);

}  // namespace maille
