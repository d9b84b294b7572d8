// A lattice as the two ways of resampling look at it: its moved bricks and where they have got to.
#pragma once

#include <cstdint>
#include <vector>

#include "deform/cuts.h"
#include "deform/lattice.h"
#include "resample/cell_cover.h"
#include "resample/deformed_cell.h"

namespace maille {

struct DeformedVolume {
  // The moved elements of a brick.
  struct Entry {
    CellCover cover;
    bool at_border;  // there are elements of the volume's border among them
    bool cut;        // some of its cells may be cut
  };

  Lattice lattice;
  Cuts cuts;
  bool any_cut = false;
  glm::vec3 spacing_mm{1};
  CellMap cell_map;            // of cells; where a cut is in sight they are trilinear
  std::vector<Entry> entries;  // by rising brick: answers do not depend on who asks
  // Whether any border element has moved. Only then can material have left a voxel of the volume
  // with nothing: while the whole border rests, what it encloses covers every voxel.
  bool border_moved = false;

  // Neither copied nor moved: its parts point at one another.
  DeformedVolume(Lattice deformed, Cuts with_cuts, glm::dvec3 spacing,
                 CellMap map = CellMap::trilinear);
  DeformedVolume(const DeformedVolume&) = delete;
  DeformedVolume& operator=(const DeformedVolume&) = delete;

  Size3 size() const { return lattice.grid().volume_size(); }
  const Cuts* cuts_or_null() const { return any_cut ? &cuts : nullptr; }
  // Of the brick that a voxel lies in; null: nothing has moved, or been cut, or it is none of the
  // volume's.
  const LatticeBrick* moved_at(VoxelIndex voxel) const;
  const CutBrick* cuts_at(VoxelIndex voxel) const;
};

}  // namespace maille
