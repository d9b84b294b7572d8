#include "references/nearest_brute_force.h"

#include <cmath>
#include <limits>

namespace maille {

NearestBruteForce::NearestBruteForce(const DeformedElements& elements)
    : elements_(elements),
      bins_(elements.size()),
      lowest_mm_(elements.at_mm(0)),
      edge_mm_(elements.spacing_mm()) {
  glm::dvec3 highest_mm = lowest_mm_;
  for (std::size_t i = 0; i < elements_.count(); ++i) {
    lowest_mm_ = glm::min(lowest_mm_, elements_.at_mm(i));
    highest_mm = glm::max(highest_mm, elements_.at_mm(i));
  }
  extent_mm_ = highest_mm - lowest_mm_;
  for (int c = 0; c < 3; ++c) {
    if (extent_mm_[c] > 0.0) edge_mm_[c] = extent_mm_[c] / bins_[c];
  }
  std::vector<std::size_t> bin_of(elements_.count());
  first_.assign(static_cast<std::size_t>(voxel_count(bins_)) + 1, 0);
  for (std::size_t i = 0; i < elements_.count(); ++i) {
    // The highest lies at the end of the last bin.
    const VoxelIndex bin = glm::clamp(VoxelIndex(bins_from_lowest(elements_.at_mm(i))),
                                      VoxelIndex(0), VoxelIndex(bins_ - 1));
    bin_of[i] = element_of(bin, bins_);
    ++first_[bin_of[i] + 1];
  }
  for (std::size_t b = 1; b < first_.size(); ++b) first_[b] += first_[b - 1];
  sorted_.resize(elements_.count());
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t i = 0; i < elements_.count(); ++i) sorted_[next[bin_of[i]]++] = i;
}

void NearestBruteForce::look_into(VoxelIndex bin, glm::dvec3 point_mm,
                                  ElementDistance& best) const {
  const std::size_t b = element_of(bin, bins_);
  for (std::size_t k = first_[b]; k < first_[b + 1]; ++k) {
    const ElementDistance here = elements_.distance(sorted_[k], point_mm);
    if (here.before(best)) best = here;
  }
}

double NearestBruteForce::least_squared_mm2_beyond(VoxelIndex lo, VoxelIndex hi,
                                                   glm::dvec3 point_mm) const {
  // All from the lowest corner, as bins are: the margin is for the rounding of positions to them.
  constexpr double kMargin_bins = 1e-9;
  const glm::dvec3 at_mm = point_mm - lowest_mm_;
  const glm::dvec3 margin_mm = kMargin_bins * edge_mm_;
  const auto squared = [](double gap_mm) { return gap_mm > 0.0 ? gap_mm * gap_mm : 0.0; };
  // A point in front of the whole grid is at least that far from all of it.
  glm::dvec3 in_front_mm2;
  for (int c = 0; c < 3; ++c) {
    in_front_mm2[c] = squared(std::max(-at_mm[c], at_mm[c] - extent_mm_[c]) - margin_mm[c]);
  }
  double least = std::numeric_limits<double>::infinity();
  for (int c = 0; c < 3; ++c) {
    const double across_mm2 = in_front_mm2.x + in_front_mm2.y + in_front_mm2.z - in_front_mm2[c];
    if (lo[c] > 0) {
      least = std::min(least, across_mm2 + squared(at_mm[c] - lo[c] * edge_mm_[c] - margin_mm[c]));
    }
    if (hi[c] < bins_[c] - 1) {
      const double end_mm = (hi[c] + 1) * edge_mm_[c];
      least = std::min(least, across_mm2 + squared(end_mm - at_mm[c] - margin_mm[c]));
    }
  }
  return least;
}

ElementDistance NearestBruteForce::nearest_to(glm::dvec3 point_mm) const {
  // Shells are counted around the bin of the grid that lies nearest, so that a point far outside
  // has no empty ones to pass.
  const glm::dvec3 last(bins_ - 1);
  const VoxelIndex center(glm::clamp(bins_from_lowest(point_mm), glm::dvec3(0.0), last));
  ElementDistance best{elements_.count(), std::numeric_limits<double>::infinity()};
  for (int shell = 0;; ++shell) {
    const VoxelIndex lo = center - shell;
    const VoxelIndex hi = center + shell;
    for (int z = std::max(lo.z, 0); z <= std::min(hi.z, bins_.z - 1); ++z) {
      for (int y = std::max(lo.y, 0); y <= std::min(hi.y, bins_.y - 1); ++y) {
        const bool whole_row = z == lo.z || z == hi.z || y == lo.y || y == hi.y;
        if (whole_row) {
          for (int x = std::max(lo.x, 0); x <= std::min(hi.x, bins_.x - 1); ++x) {
            look_into({x, y, z}, point_mm, best);
          }
        } else {
          if (lo.x >= 0) look_into({lo.x, y, z}, point_mm, best);
          if (hi.x < bins_.x) look_into({hi.x, y, z}, point_mm, best);
        }
      }
    }
    // Not where it is equal: out there may be one as near with a lower index.
    const double beyond_mm2 = least_squared_mm2_beyond(lo, hi, point_mm);
    if (std::isinf(beyond_mm2) || best.squared_mm2 < beyond_mm2) return best;
  }
}

}  // namespace maille
