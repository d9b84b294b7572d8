#include "deform/springs.h"

namespace maille {

Springs springs_of(glm::dvec3 spacing_mm) {
  constexpr std::array<glm::ivec3, kSprings / 2> kOffsets = {{{1, 0, 0},
                                                              {0, 1, 0},
                                                              {0, 0, 1},
                                                              {1, 1, 0},
                                                              {1, -1, 0},
                                                              {1, 0, 1},
                                                              {1, 0, -1},
                                                              {0, 1, 1},
                                                              {0, 1, -1}}};
  Springs springs;
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const glm::ivec3 o = s % 2 ? -kOffsets[s / 2] : kOffsets[s / 2];
    const glm::vec3 rest_mm = -glm::vec3(glm::dvec3(o) * spacing_mm);
    springs[s] = {o, rest_mm, glm::length(rest_mm)};
  }
  return springs;
}

}  // namespace maille
