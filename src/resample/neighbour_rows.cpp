#include "resample/neighbour_rows.h"

#include <algorithm>

namespace maille {

void NeighbourRows::fill_displacements(const DisplacementTile& tile) {
  // What the border's squared distances are is a float, and further than anything that counts.
  constexpr float kNoneThere_voxels = 1e15f;
  // Rows are read four at a time from an element's neighbour on.
  width_ = tile.width() + 3;
  height_ = tile.height() + 2;
  const int depth = tile.depth() + 2;
  rows_.resize(static_cast<std::size_t>(4 * width_) * static_cast<std::size_t>(height_ * depth));
  for (int z = -1; z <= tile.depth(); ++z) {
    for (int y = -1; y <= tile.height(); ++y) {
      float* const to = row(y, z);
      if (z < 0 || z == tile.depth() || y < 0 || y == tile.height()) {
        std::fill_n(to, 3 * width_, kNoneThere_voxels);
        std::fill_n(to + 3 * width_, width_, 0.0f);
        continue;
      }
      const Float4* const u = tile.row(y, z);
      for (int c = 0; c < 3; ++c) {
        float* const of_component = to + c * width_;
        of_component[0] = kNoneThere_voxels;
        for (int x = 0; x < tile.width(); ++x) of_component[x + 1] = u[x][c];
        std::fill(of_component + tile.width() + 1, of_component + width_, kNoneThere_voxels);
      }
      to[3 * width_] = 0.0f;
      std::fill(to + 3 * width_ + tile.width() + 1, to + 4 * width_, 0.0f);
    }
  }
}

void NeighbourRows::take(VoxelIndex element, Float4 now, GaussianMean& mean, int x) const {
  const Float4 along_row{-1.0f, 0.0f, 1.0f, 2.0f};
  const Float4 spare{0.0f, 0.0f, 0.0f, GaussianMean::kNowhere};
  const Float4 from_x = along_row + (static_cast<float>(element.x) - now[0]);
  const auto load = [](const float* from) {
    Float4 four;
    __builtin_memcpy(&four, from, sizeof four);
    return four;
  };
  const std::ptrdiff_t width = width_;
  const float* of_plane = row(element.y - 1, element.z - 1) + element.x;
  for (int z = -1, k = 0; z <= 1; ++z, of_plane += 4 * width * height_) {
    const float* at = of_plane;
    const Float4 from_z = splat(static_cast<float>(element.z + z) - now[2]);
    for (int y = -1; y <= 1; ++y, ++k, at += 4 * width) {
      const Float4 from_y = splat(static_cast<float>(element.y + y) - now[1]);
      const Float4 away_x = load(at) + from_x;
      const Float4 away_y = load(at + width) + from_y;
      const Float4 away_z = load(at + 2 * width) + from_z;
      const Float4 value = load(at + 3 * width);
      const Float4 squared = away_x * away_x + away_y * away_y + away_z * away_z + spare;
      __builtin_memcpy(mean.squared_voxels(x, k), &squared, sizeof squared);
      __builtin_memcpy(mean.value(x, k), &value, sizeof value);
    }
  }
}

}  // namespace maille
