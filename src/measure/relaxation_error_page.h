// What measure_relaxation_error() found, for a person and for a program.
#pragma once

#include "measure/page.h"
#include "measure/relaxation_error.h"

namespace maille {

MeasurePage page_of(const RelaxationError& report);

}  // namespace maille
