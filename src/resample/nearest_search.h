// Which element lies nearest to a point, where the point at rest that lies there is known and no
// two points of the tile come to lie on one another.
//
// How far to look: with M the injection's inverse and B its spread, an element whose rest position
// is D away from the point's lies so far off that |M (x_e - x) - D| <= B |D|, component by
// component. So none is nearer than an element at distance d that is further than
//
//     |D| <= (1 - B)^-1 m d,   m_c the length of M's row c per mm,
//
// away along some axis: a box of two or three elements each way, where cells are not drawn long.
// That holds for every lattice with an injection, not only for smooth ones: it is not a guess.
//
// It holds for any box of cells around the point too, and the bounds of a small one are tighter,
// where the box of elements to look at lies inside it: the way from the point to an element that is
// as near, straight as things lie now, starts inside, and cannot leave, since all that lies on the
// border is further away; and no other element lies where it ends.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/one_of_widths.h"
#include "resample/displacement_tile.h"
#include "resample/edge_blocks.h"

namespace maille {

class NearestSearch {
 public:
  // What most searches need.
  static constexpr int kUsuallyAround_voxels = 2;
  // So far around the points the tile must hold all elements there are.
  static int around_voxels(const DisplacementTile::Injection& injection, glm::vec3 spacing_mm);

  // points: how many will be asked for.
  NearestSearch(const DisplacementTile& tile, const DisplacementTile::Injection& injection,
                glm::vec3 spacing_mm, std::int64_t points, Registers registers = Registers::widest);

  struct Found {
    quads::Ints<1> element;
    float squared_mm;  // from the point
    bool maybe_further;
  };
  // Of a row of points, a voxel apart along x from `now` on: where they lie (less what is common to
  // the tile), and were at rest, counted from the tile's first element, in voxels; behind the last
  // there is one more that may be read, and one that may be written. Bit x of `wanted`: which to
  // tell. Ties to the lower element.
  void find(Float4 now, const Float4* rest, int count, std::uint32_t wanted, Found* found);

  // How far to look, in voxels at rest for each mm of distance, and around which elements that
  // holds.
  struct Block {
    Float4 reach_squared;  // first of all
    Float4 reach;
    Float4 lo, hi;
  };
  // What a search among the corners of a cell reads.
  struct Corners {
    const char* u;
    const char* blocks;
    std::array<std::ptrdiff_t, 8> steps;  // bytes
    glm::vec3 spacing_mm;
    glm::vec3 last, last_cell;
    glm::ivec3 strides;        // of elements
    glm::ivec3 block_strides;  // bytes
  };

 private:
  const Block& block_of(Float4 rest);
  void look_further(Float4 now, Float4 rest, Found& found);

  const DisplacementTile& tile_;
  Registers registers_;
  Float4 spacing_mm_;
  Float4 last_;   // of the tile's elements
  Float4 reach_;  // as a block's, everywhere
  std::optional<EdgeBlocks> edges_;
  std::vector<Block> blocks_;  // or one for all; each is found out when a search first asks
  Corners corners_;
};

}  // namespace maille
