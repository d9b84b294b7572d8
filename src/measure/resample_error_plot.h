// The picture of measure_resample_error().
#pragma once

#include <string>

#include "measure/resample_error.h"

namespace maille {

std::string svg_of(const ResampleError& report);

}  // namespace maille
