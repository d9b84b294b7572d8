// What measure_speed() found, for a person and for a program.
#pragma once

#include "measure/page.h"
#include "measure/speed.h"

namespace maille {

MeasurePage page_of(const SpeedReport& report);

}  // namespace maille
