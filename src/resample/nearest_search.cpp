#include "resample/nearest_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille {

NearestSearch::NearestSearch(const DisplacementTile& tile,
                             const DisplacementTile::Injection& injection, glm::vec3 spacing_mm)
    : tile_(tile), spacing_mm_{spacing_mm.x, spacing_mm.y, spacing_mm.z, 0.0f} {
  const VoxelIndex last = tile.elements().size() - 1;
  const VoxelIndex last_cell = glm::max(last - 1, VoxelIndex(0));
  for (int c = 0; c < 3; ++c) {
    last_[c] = static_cast<float>(last[c]);
    last_cell_[c] = static_cast<float>(last_cell[c]);
  }
  for (unsigned k = 0; k < 8; ++k) {
    const VoxelIndex at = glm::min(VoxelIndex(k & 1u, k >> 1 & 1u, k >> 2), last);
    for (int c = 0; c < 3; ++c) corner_[k][c] = static_cast<float>(at[c]);
    offset_[k] = (std::ptrdiff_t{at.z} * tile.height() + at.y) * tile.width() + at.x;
  }
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
  const glm::dmat3 left = glm::dmat3(1.0) - (1.0 + kSlack) * injection.spread;
  const auto reach = glm::vec3(glm::inverse(left) * row_lengths * (1.0 + kSlack));
  reach_ = Float4{reach.x, reach.y, reach.z, 0.0f};
  // A point is no further from some corner of its cell than half the diagonal of the cell's bounds.
  const float furthest_mm = glm::length(0.5f * injection.largest_cell_voxels * spacing_mm);
  const float most = furthest_mm / std::min({spacing_mm.x, spacing_mm.y, spacing_mm.z});
  // Most points are not the furthest.
  const glm::vec3 looked_at = glm::vec3(1.0f) + 2.0f * reach * (0.4f * furthest_mm);
  candidates_ = looked_at.x * looked_at.y * looked_at.z;
  constexpr float kMost = 1e6f;
  around_voxels_ = static_cast<int>(std::min(most, kMost)) + 1;
}

namespace {

[[gnu::always_inline]] inline Float4 nearest_whole(Float4 value) {
  const Float4 one_and_a_half_times_2_to_23 = splat(12582912.0f);
  return (value + one_and_a_half_times_2_to_23) - one_and_a_half_times_2_to_23;
}

[[gnu::always_inline]] inline Float4 floor(Float4 value) {
  const Float4 whole = nearest_whole(value);
  return whole > value ? whole - 1.0f : whole;
}

[[gnu::always_inline]] inline Float4 ceil(Float4 value) {
  const Float4 whole = nearest_whole(value);
  return whole < value ? whole + 1.0f : whole;
}

}  // namespace

VoxelIndex NearestSearch::operator()(Float4 now, Float4 rest) const {
  // Most often it is one of those around the point at rest: all eight at once, without a branch
  // that depends on where in its cell the point is.
  const Float4 inside = least(greatest(rest, Float4{}), last_);
  const Float4 base = floor(least(inside, last_cell_));
  const Int4 cell = __builtin_convertvector(base, Int4);
  const Float4* const u = tile_.row(cell[1], cell[2]) + cell[0];
  const Float4 from = base - now;
  Float4 squares[8];
  for (std::size_t k = 0; k < 8; ++k) {
    const Float4 away = (u[offset_[k]] + (from + corner_[k])) * spacing_mm_;
    squares[k] = away * away;
  }
  const Float4 near = quads::sums<1>(squares[0], squares[1], squares[2], squares[3]);
  const Float4 far = quads::sums<1>(squares[4], squares[5], squares[6], squares[7]);
  int corner = 0;
  float least_squared = near[0];
  for (int k = 1; k < 8; ++k) {
    const float squared = k < 4 ? near[k] : far[k - 4];
    corner = squared < least_squared ? k : corner;
    least_squared = squared < least_squared ? squared : least_squared;
  }
  const Float4 reach = reach_ * splat(std::sqrt(least_squared));
  const Float4 lowest = ceil(least(greatest(rest - reach, Float4{}), last_));
  const Float4 highest = floor(least(greatest(rest + reach, Float4{}), last_));
  const Int4 further = (lowest < base) | (highest > base + 1.0f);
  if ((further[0] | further[1] | further[2]) == 0) {
    return {cell[0] + (corner & 1), cell[1] + (corner >> 1 & 1), cell[2] + (corner >> 2)};
  }
  return among(now, __builtin_convertvector(lowest, Int4), __builtin_convertvector(highest, Int4));
}

VoxelIndex NearestSearch::among(Float4 now, Int4 first, Int4 last) const {
  VoxelIndex best(0);
  float least_squared = std::numeric_limits<float>::infinity();
  for (int z = first[2]; z <= last[2]; ++z) {
    for (int y = first[1]; y <= last[1]; ++y) {
      const Float4* const u = tile_.row(y, z);
      const Float4 row = Float4{0.0f, static_cast<float>(y), static_cast<float>(z), 0.0f} - now;
      for (int x = first[0]; x <= last[0]; ++x) {
        const Float4 away = (u[x] + (row + Float4{static_cast<float>(x), 0, 0, 0})) * spacing_mm_;
        const float squared = quads::sums<1>(away * away, Float4{}, Float4{}, Float4{})[0];
        if (squared < least_squared) {
          least_squared = squared;
          best = {x, y, z};
        }
      }
    }
  }
  return best;
}

}  // namespace maille
