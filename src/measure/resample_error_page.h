// What measure_resample_error() found, for a person and for a program.
#pragma once

#include "measure/page.h"
#include "measure/resample_error.h"

namespace maille {

MeasurePage page_of(const ResampleError& report);

// "Maille", "walk, 6", "walk, 26" or "fixed point, 3".
std::string way_of(const ResampleError::Row& row);

}  // namespace maille
