#include "resample/nearest_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille {

NearestSearch::NearestSearch(const DisplacementTile& tile,
                             const DisplacementTile::Injection& injection, glm::vec3 spacing_mm)
    : tile_(tile), spacing_mm_{spacing_mm.x, spacing_mm.y, spacing_mm.z, 0.0f} {
  // What floats leave open, of the injection and of distances.
  constexpr double kSlack = 1e-4;
  const double share = injection.share + kSlack;
  if (!(share < 1.0)) return;
  glm::dvec3 row_lengths(0.0);
  for (int c = 0; c < 3; ++c) {
    glm::dvec3 row;
    for (int axis = 0; axis < 3; ++axis) {
      row[axis] = double{injection.inverse[axis][c]} / double{spacing_mm[axis]};
    }
    row_lengths[c] = glm::length(row);
  }
  const double largest = std::max({row_lengths.x, row_lengths.y, row_lengths.z});
  reach_ = glm::vec3((row_lengths + share * largest / (1.0 - share)) * (1.0 + kSlack));
  // A point is no further from some corner of its cell than half the diagonal of the cell's bounds.
  const glm::vec3 half_diagonal_mm = 0.5f * injection.largest_cell_voxels * spacing_mm;
  const glm::vec3 furthest = reach_ * glm::length(half_diagonal_mm);
  within_margin_ = std::max({furthest.x, furthest.y, furthest.z}) < kMargin + 1;
}

namespace {

float squared_length(Float4 away) {
  const Float4 squared = away * away;
  return (squared[2] + squared[1]) + squared[0];
}

}  // namespace

VoxelIndex NearestSearch::operator()(Float4 now, Float4 rest) const {
  const VoxelIndex last = tile_.elements().size() - 1;
  // Most often it is the one that was nearest at rest.
  VoxelIndex best;
  for (int c = 0; c < 3; ++c) {
    best[c] = std::clamp(static_cast<int>(rest[c] + 0.5f), 0, last[c]);
  }
  const Float4 best_at{static_cast<float>(best.x), static_cast<float>(best.y),
                       static_cast<float>(best.z), 0.0f};
  const float guess =
      squared_length((best_at + tile_.row(best.y, best.z)[best.x] - now) * spacing_mm_);
  const float distance_mm = std::sqrt(guess);
  VoxelIndex first;
  VoxelIndex end;
  for (int c = 0; c < 3; ++c) {
    const float reach = reach_[c] * distance_mm;
    const float lowest = std::max(rest[c] - reach, 0.0f);
    first[c] = std::min(static_cast<int>(lowest), last[c]);
    first[c] += static_cast<float>(first[c]) < lowest && first[c] < last[c];
    end[c] = std::min(static_cast<int>(std::max(rest[c] + reach, 0.0f)), last[c]) + 1;
  }
  float least = std::numeric_limits<float>::infinity();
  for (int z = first.z; z < end.z; ++z) {
    for (int y = first.y; y < end.y; ++y) {
      const Float4* const u = tile_.row(y, z);
      const Float4 row = Float4{0.0f, static_cast<float>(y), static_cast<float>(z), 0.0f} - now;
      for (int x = first.x; x < end.x; ++x) {
        const Float4 away = u[x] + (row + Float4{static_cast<float>(x), 0.0f, 0.0f, 0.0f});
        const float distance = squared_length(away * spacing_mm_);
        if (distance < least) {
          least = distance;
          best = {x, y, z};
        }
      }
    }
  }
  return best;
}

}  // namespace maille
