// Which bricks of a deformed lattice reach into a part of space.
#pragma once

#include <cstdint>
#include <vector>

#include "deform/lattice.h"

namespace maille {

// Closed box of deformed voxel space, in voxels. Holds nothing where lo > hi or NaN.
struct SpaceBox {
  glm::dvec3 lo{0};
  glm::dvec3 hi{0};
};

// The elements of `within` (of the volume) that may lie in the box, given the least and greatest
// displacement of all of them.
VoxelBox rest_range(const SpaceBox& box, const VoxelBox& within, glm::ivec3 lowest,
                    glm::ivec3 highest);

// Where the links of a brick may be, from its elements' and the next ones' bounds.
SpaceBox bounds_of_links(const Lattice& lattice, std::int64_t brick);

// The bricks whose links may have a part in the box, by rising index. Costs the bricks that hold
// elements and the ones there would be in the box at rest, however large the volume.
std::vector<std::int64_t> bricks_with_links_in(const SpaceBox& box, const Lattice& lattice);

// Bricks with a link of which either end may have moved, by rising index. A brick's links are those
// that start in it and run to the next element along each axis.
std::vector<std::int64_t> bricks_with_moved_links(const Lattice& lattice);

}  // namespace maille
