// Displacements and values of a tile's elements once more, component by component and with a border
// of none: an element and its 26 neighbours are nine short rows of each.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "resample/displacement_tile.h"
#include "resample/gaussian_mean.h"
#include "resample/resampling.h"

namespace maille {

class NeighbourRows {
 public:
  // Of the tile, and what its elements hold. Keeps its memory from one to the next.
  template <class T>
  void fill(const DisplacementTile& tile, std::span<const T> values, Size3 volume_size) {
    fill_displacements(tile);
    const VoxelBox& elements = tile.elements();
    for (int z = 0; z < tile.depth(); ++z) {
      for (int y = 0; y < tile.height(); ++y) {
        const T* const from = &value_at(values, elements.lo + VoxelIndex(0, y, z), volume_size);
        float* const to = row(y, z) + 3 * width_ + 1;
        for (int x = 0; x < tile.width(); ++x) to[x] = static_cast<float>(from[x]);
      }
    }
  }

  // What point x is the mean of where the element is the nearest; `now`: the point, as the tile
  // counts.
  void take(VoxelIndex element, Float4 now, GaussianMean& mean, int x) const;

 private:
  void fill_displacements(const DisplacementTile& tile);
  // With the border; u along x, y and z and then the value of `width_` elements.
  const float* row(int y, int z) const {
    return &rows_[static_cast<std::size_t>(4 * width_) *
                  static_cast<std::size_t>((z + 1) * height_ + y + 1)];
  }
  float* row(int y, int z) { return const_cast<float*>(std::as_const(*this).row(y, z)); }

  int width_ = 0;
  int height_ = 0;
  std::vector<float> rows_;
};

}  // namespace maille
