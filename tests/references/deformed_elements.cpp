#include "references/deformed_elements.h"

#include <utility>

namespace maille {

DeformedElements::DeformedElements(Size3 size, glm::dvec3 spacing_mm,
                                   std::vector<glm::dvec3> u_voxels)
    : size_(size), spacing_mm_(spacing_mm), u_voxels_(std::move(u_voxels)) {
  at_mm_.reserve(u_voxels_.size());
  for (std::size_t i = 0; i < u_voxels_.size(); ++i) {
    at_mm_.push_back((glm::dvec3(voxel_of(i, size_)) + u_voxels_[i]) * spacing_mm_);
  }
}

bool DeformedElements::reaches(std::size_t element, glm::dvec3 point_mm) const {
  const double squared_mm2 = distance(element, point_mm).squared_mm2;
  if (squared_mm2 <= 0.25 * glm::dot(spacing_mm_, spacing_mm_)) return true;
  return any_cell_around(element, size_, [&](VoxelIndex base) {
    glm::dvec3 lowest = at_mm_[cell_corner(base, 0, size_)];
    glm::dvec3 highest = lowest;
    for (unsigned corner = 1; corner < 8; ++corner) {
      const glm::dvec3 at = at_mm_[cell_corner(base, corner, size_)];
      lowest = glm::min(lowest, at);
      highest = glm::max(highest, at);
    }
    const glm::dvec3 diagonal = highest - lowest;
    return squared_mm2 <= 0.25 * glm::dot(diagonal, diagonal);
  });
}

}  // namespace maille
