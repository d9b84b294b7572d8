// A deformed volume as the references of resampling see it: where every element lies now, in plain
// arrays (x fastest) and double precision, and which cells lie around an element. Nothing is cut.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "references/dense_problem.h"

namespace maille {

// How far an element lies from a point. Of two the nearer comes first, of equals the lower index:
// one order for every reference, so that a tie is no difference between them.
struct ElementDistance {
  std::size_t element;
  double squared_mm2;

  bool before(const ElementDistance& other) const {
    return squared_mm2 < other.squared_mm2 ||
           (squared_mm2 == other.squared_mm2 && element < other.element);
  }
};

class DeformedElements {
 public:
  // u_voxels: the displacement of each element.
  DeformedElements(Size3 size, glm::dvec3 spacing_mm, std::vector<glm::dvec3> u_voxels);

  Size3 size() const { return size_; }
  glm::dvec3 spacing_mm() const { return spacing_mm_; }
  std::size_t count() const { return at_mm_.size(); }
  const glm::dvec3& u_voxels(std::size_t element) const { return u_voxels_[element]; }
  // Voxel (0,0,0) of the grid that is resampled to lies at 0.
  const glm::dvec3& at_mm(std::size_t element) const { return at_mm_[element]; }

  ElementDistance distance(std::size_t element, glm::dvec3 point_mm) const {
    const glm::dvec3 away = at_mm_[element] - point_mm;
    return {element, glm::dot(away, away)};
  }

  // Whether a point may be the element's: it lies no further than half the diagonal of the bounds
  // of one of the cells around the element, or of a voxel at rest.
  //
  // A point of a cell lies within half the diagonal of the cell's bounds of one of its corners, so
  // this is the half diagonal of a voxel times the local stretch, made safe for folded and sheared
  // cells. A voxel at rest for what lies outside of all cells, in the border elements' outer
  // halves. It is a sphere: beyond a border it also takes in some of what the product gives the
  // background.
  bool reaches(std::size_t element, glm::dvec3 point_mm) const;

 private:
  Size3 size_;
  glm::dvec3 spacing_mm_;
  std::vector<glm::dvec3> u_voxels_;
  std::vector<glm::dvec3> at_mm_;
};

// Calls f(element) for each of the up to 27 in the box of neighbours around an element, itself
// among them, by ascending index.
template <class F>
void for_each_in_neighbourhood(std::size_t element, Size3 size, F&& f) {
  const VoxelIndex voxel = voxel_of(element, size);
  const VoxelIndex lo = glm::max(voxel - 1, VoxelIndex(0));
  const VoxelIndex hi = glm::min(voxel + 1, VoxelIndex(size - 1));
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      std::size_t at = element_of({lo.x, y, z}, size);
      for (int x = lo.x; x <= hi.x; ++x, ++at) f(at);
    }
  }
}

// Calls f(base) for each of the up to eight cells around an element, by ascending index of the
// base, until f returns true; returns whether it did. An axis with a single layer of elements has
// flat cells.
template <class F>
bool any_cell_around(std::size_t element, Size3 size, F&& f) {
  const VoxelIndex voxel = voxel_of(element, size);
  const VoxelIndex lo = glm::max(voxel - 1, VoxelIndex(0));
  const VoxelIndex hi = glm::min(voxel, glm::max(VoxelIndex(size - 2), VoxelIndex(0)));
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x) {
        if (f(VoxelIndex(x, y, z))) return true;
      }
    }
  }
  return false;
}

// Corner (i,j,k) of a cell for i + 2j + 4k.
inline std::size_t cell_corner(VoxelIndex base, unsigned corner, Size3 size) {
  const VoxelIndex offset(corner & 1u, corner >> 1 & 1u, corner >> 2);
  return element_of(glm::min(base + offset, VoxelIndex(size - 1)), size);
}

}  // namespace maille
