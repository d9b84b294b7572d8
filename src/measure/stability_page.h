// What measure_stability() found, for a person and for a program.
#pragma once

#include "measure/page.h"
#include "measure/stability.h"

namespace maille {

MeasurePage page_of(const StabilityReport& report);

}  // namespace maille
