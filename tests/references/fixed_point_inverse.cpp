#include "references/fixed_point_inverse.h"

namespace maille {
namespace {

template <class Value, class ValueOf>
Value trilinear_of(Size3 size, glm::dvec3 rest_voxels, ValueOf&& value_of) {
  const glm::dvec3 inside = glm::clamp(rest_voxels, glm::dvec3(0.0), glm::dvec3(size - 1));
  const VoxelIndex base = glm::min(VoxelIndex(inside), glm::max(size - 2, VoxelIndex(0)));
  const glm::dvec3 t = inside - glm::dvec3(base);
  Value sum(0.0);
  for (unsigned corner = 0; corner < 8; ++corner) {
    const double weight = (corner & 1u ? t.x : 1.0 - t.x) * (corner & 2u ? t.y : 1.0 - t.y) *
                          (corner & 4u ? t.z : 1.0 - t.z);
    sum += weight * value_of(cell_corner(base, corner, size));
  }
  return sum;
}

glm::dvec3 u_voxels_at(const DeformedElements& elements, glm::dvec3 rest_voxels) {
  return trilinear_of<glm::dvec3>(elements.size(), rest_voxels,
                                  [&](std::size_t i) { return elements.u_voxels(i); });
}

}  // namespace

double trilinear(Size3 size, std::span<const double> values, glm::dvec3 rest_voxels) {
  return trilinear_of<double>(size, rest_voxels, [&](std::size_t i) { return values[i]; });
}

glm::dvec3 forward_voxels(const DeformedElements& elements, glm::dvec3 rest_voxels) {
  return rest_voxels + u_voxels_at(elements, rest_voxels);
}

glm::dvec3 rest_by_fixed_point(const DeformedElements& elements, glm::dvec3 point_voxels,
                               int iterations) {
  glm::dvec3 rest_voxels = point_voxels;
  for (int i = 0; i < iterations; ++i) {
    rest_voxels = point_voxels - u_voxels_at(elements, rest_voxels);
  }
  return rest_voxels;
}

}  // namespace maille
