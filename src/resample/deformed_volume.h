// A lattice as the two ways of resampling look at it: its moved bricks and where they have got to.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "deform/cuts.h"
#include "deform/lattice.h"
#include "resample/reach.h"

namespace maille {

struct DeformedVolume {
  struct Entry {
    Reach reach;
    VoxelBox covered;
    bool at_border;  // holds moved elements of the volume's border
    bool cut;        // some of its cells may be cut
  };

  Lattice lattice;
  Cuts cuts;
  bool any_cut = false;
  glm::vec3 spacing_mm{1};
  std::vector<Entry> entries;  // by rising brick: answers do not depend on who asks
  // Whether any border element has moved. Only then can material have left a voxel of the volume
  // with nothing: while the whole border rests, what it encloses covers every voxel.
  bool border_moved = false;

  DeformedVolume(Lattice deformed, Cuts with_cuts, glm::dvec3 spacing);
  Size3 size() const { return lattice.grid().volume_size(); }
  const Cuts* cuts_or_null() const { return any_cut ? &cuts : nullptr; }
  // Whether moved cut cells may touch one of the voxels.
  bool cut_in_sight(const VoxelBox& voxels) const;
  // Elements of all cells that can cover one of the voxels, and some around them.
  VoxelBox elements_over(const VoxelBox& voxels) const;
  // By how many whole voxels all that can cover a brick is displaced, where it is that simple.
  std::optional<glm::ivec3> whole_shift(std::int64_t brick) const;
  VoxelBox box(std::int64_t brick) const { return lattice.grid().box(lattice.grid().brick(brick)); }
};

// Those of a reach's cells whose bounds allow them to touch a box of points (voxel space).
VoxelBox cells_over(const Reach& reach, glm::dvec3 lo, glm::dvec3 hi);

}  // namespace maille
