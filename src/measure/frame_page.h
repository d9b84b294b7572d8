// What measure_frame() found, for a person and for a program.
#pragma once

#include "measure/frame.h"
#include "measure/page.h"

namespace maille {

MeasurePage page_of(const FrameReport& report);

}  // namespace maille
