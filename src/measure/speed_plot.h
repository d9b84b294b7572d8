// What measure_speed() found, as a drawing.
#pragma once

#include <string>

#include "measure/speed.h"

namespace maille {

std::string svg_of(const SpeedReport& report);

}  // namespace maille
