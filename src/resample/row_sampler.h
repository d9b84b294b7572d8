// Values of a volume at a row of rest positions, interpolated as cells are mapped.
//
// In three loops over the row: where each lies, its eight values, and what they mix to. The first
// and the last are the compiler's to take many neighbours at a time (several_widths.h).
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include "core/several_widths.h"
#include "resample/deformed_cell.h"
#include "volume/brick.h"

namespace maille {

class RowSampler {
 public:
  // Positions are counted from the lowest of the elements, in voxels. Only among these elements is
  // anything that may lie there; where they end with the volume, half a voxel beyond them too.
  RowSampler(Size3 size, const VoxelBox& elements);

  // Row of `count` positions, at most a brick's. A point on an element, but for rounding, takes its
  // value unmixed, so that whole-voxel shifts copy; equal values, infinite ones among them, mix to
  // themselves, and no value counts that a point has nothing of. Also tells which lie among the
  // elements.
  template <class T>
  void sample(std::span<const T> voxels, CellMap map, const Float4* rest, int count) {
    locate(rest, count);
    if (map == CellMap::tetrahedra) return sample_tetrahedra(voxels, count);
    for (int x = 0; x < count; ++x) {
      const T* const p = &voxels[static_cast<std::size_t>(offset_[x])];
      const T* const q = p + step_z_;
      corner_[0][x] = static_cast<float>(p[0]);
      corner_[1][x] = static_cast<float>(p[step_x_]);
      corner_[2][x] = static_cast<float>(p[step_y_]);
      corner_[3][x] = static_cast<float>(p[step_y_ + step_x_]);
      corner_[4][x] = static_cast<float>(q[0]);
      corner_[5][x] = static_cast<float>(q[step_x_]);
      corner_[6][x] = static_cast<float>(q[step_y_]);
      corner_[7][x] = static_cast<float>(q[step_y_ + step_x_]);
    }
    mix(count);
  }

  float value(int x) const { return value_[x]; }
  bool is_among(int x) const { return among_[x] != 0; }
  bool all_among() const { return all_among_; }
  // Bit x: whether x is among them.
  std::uint32_t among(int count) const {
    std::uint32_t bits = 0;
    for (int x = 0; x < count; ++x) bits |= static_cast<std::uint32_t>(among_[x] != 0) << x;
    return bits;
  }

  void locate(const Float4* rest, int count);
  glm::vec3 position(int x) const { return {at_[0][x], at_[1][x], at_[2][x]}; }

 private:
  template <class T>
  void sample_tetrahedra(std::span<const T> voxels, int count) {
    choose_tetrahedra(count);
    for (int x = 0; x < count; ++x) {
      const T* const p = &voxels[static_cast<std::size_t>(offset_[x])];
      corner_[0][x] = static_cast<float>(p[0]);
      corner_[1][x] = static_cast<float>(p[second_[x]]);
      corner_[2][x] = static_cast<float>(p[third_[x]]);
      corner_[3][x] = static_cast<float>(p[step_x_ + step_y_ + step_z_]);
    }
    mix_along_path(count);
  }

  void mix(int count);
  void choose_tetrahedra(int count);
  void mix_along_path(int count);

  VoxelIndex first_;
  Size3 size_;
  glm::vec3 lowest_;  // that lies among the elements
  glm::vec3 highest_;
  std::int64_t step_x_;
  std::int64_t step_y_;
  std::int64_t step_z_;
  alignas(64) float at_[3][kBrickEdge];  // positions
  alignas(64) float t_[3][kBrickEdge];   // in their cells
  alignas(64) std::int64_t offset_[kBrickEdge];
  alignas(64) std::int32_t among_[kBrickEdge];
  alignas(64) float corner_[8][kBrickEdge];
  // Of a tetrahedron, along its path from the lowest corner to the opposite one.
  alignas(64) float along_[3][kBrickEdge];  // the components of t, falling
  alignas(64) std::int64_t second_[kBrickEdge];
  alignas(64) std::int64_t third_[kBrickEdge];
  bool all_among_ = false;
  alignas(64) float value_[kBrickEdge];
};

}  // namespace maille
