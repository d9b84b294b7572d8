// What a ray hit.
#pragma once

#include <glm/glm.hpp>

namespace maille {

struct PickHit {
  glm::dvec3 voxel{0};  // continuous, voxel space
  glm::dvec3 world_mm{0};
  double value = 0.0;    // interpolated there, stored units
  glm::dvec3 normal{0};  // world, unit, towards the viewer's side of the surface; 0 where flat
};

}  // namespace maille
