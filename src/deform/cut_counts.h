// How much has been taken out of a lattice.
#pragma once

#include <cstdint>

#include "deform/cuts.h"

namespace maille {

struct CutCounts {
  std::int64_t links_removed = 0;  // those of carved elements included
  std::int64_t elements_carved = 0;
};

CutCounts count_removed(const Cuts& cuts);

}  // namespace maille
