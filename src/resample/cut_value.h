// The value of a point of a cut cell: interpolated in the octant that holds it.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "resample/cut_cell.h"
#include "volume/volume.h"

namespace maille {

// rest lies in an octant of element's own. A value of T's range, between those of the elements it
// is made of.
template <class T>
double value_in_octant(std::span<const T> voxels, const Cuts& cuts, VoxelIndex element,
                       glm::vec3 rest) {
  const Size3 size = cuts.grid().volume_size();
  glm::dvec3 t;  // from the element to the cell's middle
  VoxelIndex base = element;
  unsigned corner = 0;
  for (int c = 0; c < 3; ++c) {
    const double away = std::clamp<double>(rest[c], 0, size[c] - 1) - element[c];
    t[c] = std::min(2.0 * std::abs(away), 1.0);
    if (away < 0) {
      --base[c];
      corner |= 1u << c;
    }
  }
  const CutCell cell(cuts, base);
  // In double, so that the mean of equal values is their value to the bit.
  const auto at_middle = [&](unsigned axes) {
    double sum = 0.0;
    int count = 0;
    for_each_corner(cell.joined(corner, axes), [&](unsigned k) {
      sum += static_cast<double>(
          voxels[static_cast<std::size_t>(linear_index(cell.element(k), size))]);
      ++count;
    });
    return sum / count;
  };
  // Equal ends, infinite ones among them, must give themselves back; and no end counts that the
  // point has nothing of.
  const auto mix = [](double s, auto&& a, auto&& b) {
    const double from = a();
    if (s == 0.0) return from;
    const double to = b();
    return s == 1.0 ? to : from == to ? from : from + s * (to - from);
  };
  const auto along_x = [&](unsigned axes) {
    return mix(
        t.x, [&] { return at_middle(axes); }, [&] { return at_middle(axes | 1u); });
  };
  const auto along_y = [&](unsigned axes) {
    return mix(
        t.y, [&] { return along_x(axes); }, [&] { return along_x(axes | 2u); });
  };
  return mix(
      t.z, [&] { return along_y(0); }, [&] { return along_y(4u); });
}

}  // namespace maille
