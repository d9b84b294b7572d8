// Rest positions of a box of voxels, one after the other: each starts where the ones before it say
// that it should lie, and takes one Newton step on the cell's map, seldom two.
//
// Only where the tile's map is known to put no two points in one place (DisplacementTile::
// injection): there is one answer, and whatever way it is found it is the answer of the cell that
// covers the voxel. Where it may not be so, cells have to look for voxels (rest_finder.h).
//
// x, y and z of a voxel lie side by side, and as many voxels as a register holds (quads.h): gathers
// for each component of 16 voxels would take longer than the eight loads of each.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/one_of_widths.h"
#include "resample/displacement_tile.h"
#include "resample/sight.h"

namespace maille {

class RestMarch {
 public:
  // voxels: at most a brick's. The tile must hold all elements of the cells that can cover them.
  // No longer than the tile.
  RestMarch(const DisplacementTile& tile, const DisplacementTile::Injection& injection,
            const VoxelBox& voxels, CellMap map, Registers registers = Registers::widest);

  // Of a row's voxels, from the tile's first element on, in voxels; rows by rising y, then z, none
  // left out. Beyond the tile's elements: where the map of the nearest has it. The same bits for
  // any width of registers.
  const Float4* next_row();
  const DisplacementTile& tile() const { return *tile_; }
  const DisplacementTile::Injection& injection() const { return injection_; }

 private:
  const DisplacementTile* tile_;
  DisplacementTile::Injection injection_;
  Float4 first_;  // voxel, from the tile's first element, less what is common
  Size3 extent_;
  CellMap map_;
  Registers registers_;
  int y_ = 0;
  int z_ = 0;
  std::array<std::vector<Float4>, 2> planes_;  // rest positions of this one and the one before
};

// What a march's tile holds more than what can cover the voxels.
struct TileMargin {
  int voxels = 0;    // what can cover so much around them,
  int elements = 0;  // and so many elements around that
};

// Through voxels of a deformed volume, with a tile that this thread keeps for it until it asks for
// another. None beside cuts, nor where two cells might cover one voxel, nor where there is very
// much more material than voxels.
std::optional<RestMarch> march_through(const Sight& sight, const VoxelBox& voxels,
                                       const TileMargin& margin = {});

}  // namespace maille
