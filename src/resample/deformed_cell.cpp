#include "resample/deformed_cell.h"

namespace maille {
namespace {

glm::vec3 xyz(Float4 v) { return {v[0], v[1], v[2]}; }

}  // namespace

bool DeformedCell::folded() const {
  for (std::size_t i = 0; i < 8; ++i) {
    const glm::vec3 here = xyz(corner[i]);
    const auto edge = [&](std::size_t bit) {
      const glm::vec3 along = xyz(corner[i ^ bit]) - here;
      return i & bit ? -along : along;
    };
    if (glm::determinant(glm::mat3(edge(1), edge(2), edge(4))) <= 0.0f) return true;
  }
  return false;
}

}  // namespace maille
