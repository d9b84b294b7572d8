// What measure_chainmail_error() found, for a person and for a program.
#pragma once

#include "measure/chainmail_error.h"
#include "measure/page.h"

namespace maille {

MeasurePage page_of(const ChainMailError& report);

}  // namespace maille
