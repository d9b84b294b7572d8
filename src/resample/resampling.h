// What is resampled, and where to: the two orders of resampling stand on this.
#pragma once

#include <cstddef>

#include "resample/deformed_volume.h"
#include "resample/resample_method.h"
#include "volume/volume.h"

namespace maille {

struct Resampling {
  Volume volume;
  DeformedVolume deformed;
  ResampleMethod method;
  double background_value;

  Resampling(Volume of, Lattice lattice, Cuts cuts, ResampleMethod by, double background)
      : volume(std::move(of)),
        deformed(std::move(lattice), std::move(cuts), volume.spacing_mm(),
                 by == ResampleMethod::barycentric ? CellMap::tetrahedra : CellMap::trilinear),
        method(by),
        background_value(background) {}

  Size3 size() const { return volume.size(); }
  // Whether nothing but a cut or carving can have left a voxel with nothing.
  bool must_be_filled(VoxelIndex voxel) const {
    return !deformed.border_moved && contains(size(), voxel);
  }
};

// The value at rest of an element of the volume.
template <class T>
const T& value_at(std::span<const T> values, VoxelIndex element, Size3 size) {
  return values[static_cast<std::size_t>(linear_index(element, size))];
}

// Memory for the values of a box of voxels, x fastest, tightly packed.
struct VoxelTarget {
  VoxelBox voxels;
  std::byte* first;

  template <class T>
  T* at(VoxelIndex voxel) const {
    return reinterpret_cast<T*>(first) + linear_index(voxel - voxels.lo, voxels.size());
  }
};

}  // namespace maille
