// Resampling in image order, as in Schulze, Bühler, Hadwiger, GRAPP 2007: voxel after voxel, x
// fastest, a walk from element to neighbouring element looks for the one that lies nearest. "More
// than 99 %" find it, the paper says.
//
// A walk starts at the nearer of two guesses: the element found for the voxel before (the first
// voxel of a row: for the first of the row before; of a plane: of the plane before), and the one
// whose rest position is the voxel's less the displacement found last. It goes to the neighbour
// that lies nearest to the voxel for as long as that is nearer than where it is, and so ends in a
// local minimum. That need not be the nearest element where cells fold, shear, or are squeezed
// beside stretched ones. Where it ends too far away to be believed (DeformedElements::reaches) it
// says so; a wrong element within reach it cannot tell from the right one.
//
// What is open in this is taken so: where the voxel before has none, the last one that was found
// counts; the first voxel of all has the element of its own index alone. One thread, because each
// walk needs the one before.
#pragma once

#include <cstdint>
#include <vector>

#include "references/nearest_brute_force.h"

namespace maille {

struct PaperWalkOptions {
  enum class Neighbours {
    six,        // along the axes: those that ChainMail links
    twenty_six  // across edges and corners too
  };
  Neighbours neighbours = Neighbours::twenty_six;
  int most_steps = 1000;  // of one walk, which then gives up
};

struct WalkedVoxel {
  enum class End : std::uint8_t { found, too_far, too_many_steps };

  std::size_t element;  // where the walk ended, found or not
  int steps;            // from neighbour to neighbour
  End end;

  bool found() const { return end == End::found; }
};

// Of each voxel of lo .. hi - 1, which may lie outside of the volume; x fastest. There is at least
// one element.
std::vector<WalkedVoxel> paper_walk(const DeformedElements& elements, VoxelIndex lo, VoxelIndex hi,
                                    const PaperWalkOptions& options = {});

struct WalkCounts {
  std::int64_t voxels = 0;
  std::int64_t there = 0;    // the element that lies nearest reaches the voxel
  std::int64_t found = 0;    // by the walk
  std::int64_t right = 0;    // of these: it is the nearest
  std::int64_t missed = 0;   // there, and the walk has none: what it says itself
  std::int64_t gave_up = 0;  // not found for too many steps
  std::int64_t steps = 0;    // of all walks

  // Found, and another is nearer: what the walk does not know.
  std::int64_t wrong() const { return found - right; }
  double right_share() const {
    return there == 0 ? 1.0 : static_cast<double>(right) / static_cast<double>(there);
  }
};

// walked: of the voxels of lo .. hi - 1. nearest: of the same elements.
WalkCounts count_walks(const DeformedElements& elements, const NearestBruteForce& nearest,
                       VoxelIndex lo, VoxelIndex hi, const std::vector<WalkedVoxel>& walked);

}  // namespace maille
