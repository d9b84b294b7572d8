// Who claims a voxel: what has been found so far for the voxels of one brick.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "resample/deformed_cell.h"
#include "resample/deformed_volume.h"

namespace maille {

// How far outside of a cell a point still counts as inside.
inline constexpr float kInside_cells = 1e-4f;
// Neighbouring cells share bent faces; where one is inverted by tetrahedra a sliver may belong to
// neither. The nearest miss within this share of a cell takes such a voxel.
inline constexpr float kNearMiss_cells = 0.25f;
// Every miss scores above every hit.
inline constexpr float kMissPenalty = 1e20f;
// A point this close to an element takes its value unmixed, so that whole-voxel shifts copy.
inline constexpr float kOnElement_cells = 1e-5f;

struct Claim {
  float score;           // squared distance to the element in mm, or a penalty: the least wins
  std::int64_t element;  // linear index; the lower wins a tie
  glm::vec3 rest;        // rest position (voxel space)

  bool beats(float other_score, std::int64_t other_element) const {
    return score < other_score || (score == other_score && element < other_element);
  }
};

// Rest position of a point of a cell: its border cells are half a voxel long.
glm::vec3 rest_in_cell(VoxelIndex base, glm::vec3 t, Size3 size);

// How well a cell may claim a point that it finds at t, where the claiming element lies now.
float score_of(glm::vec3 t, Float4 element_at, glm::vec3 point, const DeformedVolume& volume);

// x fastest, tightly packed.
struct BrickClaims {
  std::vector<float> score;
  std::vector<std::int64_t> element;
  std::vector<glm::vec3> rest;  // where that is what is sought
  // What cuts and carving have to do with a voxel; empty where nothing in sight is cut.
  enum CutBits : std::uint8_t {
    may_be_open = 1,  // in the bounds of a cut cell, or carved: no hole if nothing claims it
    in_octant = 2,    // claimed by an octant of a cut cell
  };
  std::vector<std::uint8_t> cut;

  static constexpr float kUncovered = std::numeric_limits<float>::infinity();
  static constexpr float kOwned = -1.0f;  // by an element at rest: no claim beats it

  // Gives the elements at rest their voxels and opens the others. Returns how many are open.
  std::int64_t open(const DeformedVolume& volume, std::int64_t brick);

  bool take(std::size_t voxel, const Claim& claim) {
    if (!claim.beats(score[voxel], element[voxel])) return false;
    score[voxel] = claim.score;
    element[voxel] = claim.element;
    rest[voxel] = claim.rest;
    return true;
  }
};

}  // namespace maille
