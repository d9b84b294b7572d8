#include "deform/deformation.h"

#include <algorithm>

namespace maille {

bool Handle::has(const std::string& name) const {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::int64_t Handle::bytes() const {
  return std::int64_t{sizeof(Handle)} +
         static_cast<std::int64_t>(elements.bricks().size() * sizeof(ElementSet::Mask));
}

}  // namespace maille
