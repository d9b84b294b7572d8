// Which element of all lies nearest to a point: what every finder is measured against.
//
// Right for any displacements, folded and torn ones included: it looks at positions alone and
// knows no neighbours. So that volumes of 64^3 elements take seconds and not hours, positions are
// sorted into the bins of a uniform grid, as many as elements, and bins are looked at in shells
// around the point until no other can hold anything nearer, or as near with a lower index. Bins
// only ever leave out what is further: a displacement that is far out of scale makes them coarse
// and the search slow, not wrong.
#pragma once

#include <vector>

#include "references/deformed_elements.h"

namespace maille {

class NearestBruteForce {
 public:
  // The elements must outlive this; there is at least one.
  explicit NearestBruteForce(const DeformedElements& elements);

  // Ties go to the lower index.
  ElementDistance nearest_to(glm::dvec3 point_mm) const;

 private:
  glm::dvec3 bins_from_lowest(glm::dvec3 point_mm) const {
    return glm::floor((point_mm - lowest_mm_) / edge_mm_);
  }
  void look_into(VoxelIndex bin, glm::dvec3 point_mm, ElementDistance& best) const;
  // No element outside of the bins lo .. hi is nearer to a point inside of them, or in front of
  // where they end with the grid. Infinite: no bin is outside.
  double least_squared_mm2_beyond(VoxelIndex lo, VoxelIndex hi, glm::dvec3 point_mm) const;

  const DeformedElements& elements_;
  Size3 bins_;
  glm::dvec3 lowest_mm_;
  glm::dvec3 extent_mm_;
  glm::dvec3 edge_mm_;               // of a bin
  std::vector<std::size_t> first_;   // [bin], in sorted_; one more at the end
  std::vector<std::size_t> sorted_;  // elements, by bin
};

}  // namespace maille
