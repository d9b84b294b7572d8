// A lattice as the two ways of resampling look at it: its moved bricks and where they have got to.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "deform/lattice.h"
#include "resample/reach.h"

namespace maille {

struct DeformedVolume {
  struct Entry {
    Reach reach;
    VoxelBox covered;
    bool at_border;  // holds moved elements of the volume's border
  };

  Lattice lattice;
  glm::vec3 spacing_mm{1};
  std::vector<Entry> entries;  // by rising brick: answers do not depend on who asks
  // Whether any border element has moved. Only then can material have left a voxel of the volume
  // with nothing: while the whole border rests, what it encloses covers every voxel.
  bool border_moved = false;

  DeformedVolume(Lattice deformed, glm::dvec3 spacing);
  Size3 size() const { return lattice.grid().volume_size(); }
};

// Those of a reach's cells whose bounds allow them to touch a box of points (voxel space).
VoxelBox cells_over(const Reach& reach, glm::dvec3 lo, glm::dvec3 hi);

// What has been found so far for the voxels of one brick, x fastest, tightly packed.
struct BrickClaims {
  // Squared distance to the claiming element in mm, or a penalty: the least wins.
  std::vector<float> score;
  std::vector<std::int64_t> element;  // linear index of the claiming element
  std::vector<glm::vec3> rest;        // rest position (voxel space), where that is what is sought

  static constexpr float kUncovered = std::numeric_limits<float>::infinity();
  static constexpr float kOwned = -1.0f;  // by an element at rest: no claim beats it

  // Gives the elements at rest their voxels and opens the others. Returns how many are open.
  std::int64_t open(const DeformedVolume& volume, std::int64_t brick);
};

}  // namespace maille
