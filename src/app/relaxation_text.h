// What the window says of relaxation while it goes on and after.
#pragma once

#include <string>
#include <vector>

#include "app/simulation.h"

namespace maille {

// Lines for a person; none where there is nothing to say.
std::vector<std::string> relaxation_text(const SimulationStatus& status);

}  // namespace maille
