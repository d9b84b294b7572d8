// Who claims a voxel: what has been found so far for a box of them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "resample/deformed_cell.h"
#include "resample/deformed_volume.h"

namespace maille {

// How far outside of a cell a point still counts as inside.
inline constexpr float kInside_cells = 1e-4f;
// How far rounding may put a voxel on the wrong side of bounds.
inline constexpr float kBoundsSlack_voxels = 1e-3f;

// Cells look for voxels twice.
enum class ClaimPass {
  inside,    // of half open bounds: most voxels are looked at once
  left_out,  // what rounding left out
};

// A point this close to an element takes its value unmixed, so that whole-voxel shifts copy.
inline constexpr float kOnElement_cells = 4e-5f;

struct Claim {
  float score;           // squared distance to the element in mm: the least wins
  std::int64_t element;  // linear index; the lower wins a tie
  glm::vec3 rest;        // rest position (voxel space)

  bool beats(float other_score, std::int64_t other_element) const {
    return score < other_score || (score == other_score && element < other_element);
  }
};

// Rest position of a point of a cell: its border cells are half a voxel long.
inline glm::vec3 rest_in_cell(VoxelIndex base, glm::vec3 t, Size3 size) {
  glm::vec3 rest;
  for (int c = 0; c < 3; ++c) {
    const auto b = static_cast<float>(base[c]);
    rest[c] = base[c] < 0              ? -0.5f + 0.5f * t[c]
              : base[c] == size[c] - 1 ? b + 0.5f * t[c]
                                       : b + t[c];
  }
  return rest;
}

// How well an element that lies there now may claim a point.
inline float score_of(Float4 element_at, glm::vec3 point, const DeformedVolume& volume) {
  const glm::vec3 at(element_at[0], element_at[1], element_at[2]);
  const glm::vec3 away = (at - point) * volume.spacing_mm;
  return glm::dot(away, away);
}

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

  bool is_open(std::size_t voxel, ClaimPass pass) const {
    return score[voxel] != kOwned && (pass == ClaimPass::inside || score[voxel] == kUncovered);
  }
  static constexpr float kUncovered = std::numeric_limits<float>::infinity();
  static constexpr float kOwned = -1.0f;  // by an element at rest: no claim beats it

  // Gives the elements at rest their voxels and opens the others. Returns how many are open.
  // voxels: of one brick.
  std::int64_t open(const DeformedVolume& volume, const VoxelBox& voxels);

  bool take(std::size_t voxel, const Claim& claim) {
    if (!claim.beats(score[voxel], element[voxel])) return false;
    score[voxel] = claim.score;
    element[voxel] = claim.element;
    rest[voxel] = claim.rest;
    return true;
  }
};

}  // namespace maille
