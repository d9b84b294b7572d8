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
#pragma once

#include <array>
#include <limits>

#include "resample/displacement_tile.h"

namespace maille {

class NearestSearch {
 public:
  // What most searches need.
  static constexpr int kUsuallyAround_voxels = 2;

  NearestSearch(const DisplacementTile& tile, const DisplacementTile::Injection& injection,
                glm::vec3 spacing_mm);

  // How many elements a search looks at, typically, beyond the eight it begins with.
  float candidates() const { return candidates_; }
  // So far around the points the tile must hold all elements there are.
  int around_voxels() const { return around_voxels_; }

  // Counted from the tile's first element, both points in voxels: where it lies now (less what is
  // common to the tile) and was at rest (in the volume). Ties to the lower element.
  VoxelIndex operator()(Float4 now, Float4 rest) const;

 private:
  using Int4 = quads::Ints<1>;
  VoxelIndex among(Float4 now, Int4 first, Int4 last) const;

  const DisplacementTile& tile_;
  Float4 spacing_mm_;
  Float4 last_{};                   // of the tile's elements
  Float4 last_cell_{};              // its lowest corner
  std::array<Float4, 8> corner_{};  // from the lowest; where there is one layer only, itself
  std::array<std::ptrdiff_t, 8> offset_{};  // the same, in the tile
  Float4 reach_{};                          // voxels at rest for each mm of distance
  float candidates_ = std::numeric_limits<float>::infinity();
  int around_voxels_ = std::numeric_limits<int>::max();
};

}  // namespace maille
