// The displacements of a box of elements, written out: what a walk over voxels reads from, and what
// tells it that there is one answer for each.
//
// Between the elements u is trilinear in a cell, or linear in each of its tetrahedra, and beyond
// them as at the nearest; x(X) = X + u(X).
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "deform/lattice.h"
#include "resample/deformed_cell.h"
#include "resample/quads.h"

namespace maille {

// Least and greatest of the edges of some cells along each axis, as columns of d u / d X.
struct EdgeBounds {
  std::array<Float4, 3> lowest;
  std::array<Float4, 3> highest;

  EdgeBounds() {
    lowest.fill(splat(std::numeric_limits<float>::max()));
    highest.fill(splat(std::numeric_limits<float>::lowest()));
  }
  void take(std::size_t axis, Float4 edge) {
    lowest[axis] = least(lowest[axis], edge);
    highest[axis] = greatest(highest[axis], edge);
  }
  void take(const EdgeBounds& other) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lowest[axis] = least(lowest[axis], other.lowest[axis]);
      highest[axis] = greatest(highest[axis], other.highest[axis]);
    }
  }
};

class DisplacementTile {
 public:
  // Of no elements.
  DisplacementTile() = default;

  // elements: in the volume, not empty. Keeps its memory from one to the next.
  void fill(const Lattice& lattice, const VoxelBox& elements);

  const VoxelBox& elements() const { return elements_; }

  // x(X) - x(Y) is matrix (X - Y) for the middle of what the cells' edges allow, up to `share` of
  // its length (in the norm of the largest component, after the inverse). Whatever lies beyond the
  // elements counts where `with_beyond` says so.
  struct Injection {
    double share = 0.0;
    glm::mat3 inverse{1.0f};  // d X / d x
    // |inverse (x(X) - x(Y)) - (X - Y)| <= spread |X - Y|, component by component; its rows' sums
    // are at most the share.
    glm::dmat3 spread{0.0};
    glm::vec3 largest_cell_voxels{1};  // no cell's bounds are larger

    // The share in the best of norms that take some components for more than others (at least the
    // spread's spectral radius, and near to it): below 1 no two points of the tile come to lie on
    // one another, and x <- x + inverse (target - x(X)) comes nearer to the one answer by that
    // share each time.
    double contraction() const;
  };
  Injection injection(bool with_beyond) const;
  // Of a box of cells whose edges are within these bounds.
  static Injection injection_of(const EdgeBounds& edges);

  // Far from rest floats would have no digits left for what matters: u is kept less so many whole
  // voxels, that are common to all. Where points lie now is less them too.
  glm::ivec3 common_voxels() const { return common_voxels_; }

  // u at the element (voxels, less what is common; fourth lane: 1 where it has moved, else 0); x,
  // y, z counted from the first.
  const Float4* row(int y, int z) const {
    return &u_[static_cast<std::size_t>((z * height_ + y) * width_)];
  }
  int width() const { return width_; }
  int height() const { return height_; }
  int depth() const { return depth_; }

  // How many components of t are larger than each; of equal ones the first counts as larger.
  template <int kQuads>
  [[gnu::always_inline]] static quads::Ints<kQuads> rank(quads::Floats<kQuads> t) {
    using I = quads::Ints<kQuads>;
    const auto next = quads::swizzle<1, 2, 0, kQuads>(t);
    const auto last = quads::swizzle<2, 0, 1, kQuads>(t);
    const I next_first = __builtin_convertvector(quads::all<kQuads>(0.0f, 0.0f, -1.0f), I);
    const I last_first = __builtin_convertvector(quads::all<kQuads>(0.0f, -1.0f, -1.0f), I);
    return -((next > t) | ((next == t) & next_first)) - ((last > t) | ((last == t) & last_first));
  }

  // Where points lie now, and how that changes with them. X: from the first element, in voxels.
  template <int kQuads>
  struct Map {
    quads::Floats<kQuads> u;
    quads::Floats<kQuads> du_dx, du_dy, du_dz;
    quads::Floats<kQuads> t;   // where in its cell; far away where it is beyond the elements
    quads::Ints<kQuads> rank;  // of its tetrahedron: how many components of t are larger
  };

  // All that a map is made from, where nothing that is written between two of them can change it:
  // to be made once before a loop. The tile must outlive it.
  template <int kQuads>
  class Reader {
    using F = quads::Floats<kQuads>;
    using I = quads::Ints<kQuads>;

   public:
    [[gnu::always_inline]] explicit Reader(const DisplacementTile& tile)
        : u_(reinterpret_cast<const char*>(tile.u_.data())),
          step_x_(tile.step_x_),
          step_y_(tile.step_y_),
          step_z_(tile.step_z_),
          last_(quads::all<kQuads>(tile.last_.x, tile.last_.y, tile.last_.z)),
          last_cell_(quads::all<kQuads>(tile.last_cell_.x, tile.last_cell_.y, tile.last_cell_.z)),
          strides_(quads::all_ints<kQuads>(1, tile.width_, tile.width_ * tile.height_)),
          steps_(quads::all_ints<kQuads>(static_cast<int>(step_x_), static_cast<int>(step_y_),
                                         static_cast<int>(step_z_))) {}

    // Where in the tile to read, and what of it to mix. Apart from the reading, so that a loop over
    // many points can do one after the other: done in one go for each, the next would wait for it,
    // since a machine looks only so many instructions ahead.
    struct Place {
      std::int32_t cell[kQuads];
      F t;
    };
    [[gnu::always_inline]] Place place(F rest) const {
      const F below_last = rest < last_ ? rest : last_;
      const F inside = below_last > 0.0f ? below_last : F{};
      const I base = __builtin_convertvector(inside < last_cell_ ? inside : last_cell_, I);
      Place place;
      place.t = inside - __builtin_convertvector(base, F);
      const I cell = quads::sum_ints<kQuads>(base * strides_);
      for (int q = 0; q < kQuads; ++q) place.cell[q] = cell[4 * q];
      return place;
    }

    template <CellMap kMap>
    [[gnu::always_inline]] Map<kQuads> at(F rest) const {
      return at<kMap>(rest, place(rest));
    }
    template <CellMap kMap>
    [[gnu::always_inline]] Map<kQuads> at(F rest, const Place& place) const {
      const char* lowest[kQuads];
      for (int q = 0; q < kQuads; ++q) {
        lowest[q] = u_ + static_cast<std::ptrdiff_t>(sizeof(Float4)) * place.cell[q];
      }
      Map<kQuads> map;
      if constexpr (kMap == CellMap::trilinear) {
        map = trilinear(lowest, place.t);
      } else {
        map = in_tetrahedron(lowest, place.t);
      }
      const F below_last = rest < last_ ? rest : last_;
      const F inside = below_last > 0.0f ? below_last : F{};
      // Beyond the elements u changes no more.
      const F within = inside == rest ? quads::all<kQuads>(1.0f) : F{};
      map.du_dx *= quads::swizzle<0, 0, 0, kQuads>(within);
      map.du_dy *= quads::swizzle<1, 1, 1, kQuads>(within);
      map.du_dz *= quads::swizzle<2, 2, 2, kQuads>(within);
      constexpr float kFar = 1e6f;
      map.t = inside == rest ? place.t : quads::all<kQuads>(kFar);
      return map;
    }

   private:
    // lowest: a cell's corner for each quad.
    [[gnu::always_inline]] Map<kQuads> trilinear(const char* const* lowest, F t) const {
      const F tx = quads::swizzle<0, 0, 0, kQuads>(t);
      const F ty = quads::swizzle<1, 1, 1, kQuads>(t);
      const F tz = quads::swizzle<2, 2, 2, kQuads>(t);
      const F c = quads::load(lowest, 0, F{});
      const F d = quads::load(lowest, step_y_, F{});
      const F e = quads::load(lowest, step_z_, F{});
      const F f = quads::load(lowest, step_z_ + step_y_, F{});
      const F cx = quads::load(lowest, step_x_, F{}) - c;
      const F dx = quads::load(lowest, step_y_ + step_x_, F{}) - d;
      const F ex = quads::load(lowest, step_z_ + step_x_, F{}) - e;
      const F fx = quads::load(lowest, step_z_ + step_y_ + step_x_, F{}) - f;
      const F c0 = c + tx * cx;
      const F e0 = e + tx * ex;
      const F near_y = d + tx * dx - c0;
      const F far_y = f + tx * fx - e0;
      const F near = c0 + ty * near_y;
      const F across = e0 + ty * far_y - near;
      const F near_x = cx + ty * (dx - cx);
      const F far_x = ex + ty * (fx - ex);
      Map<kQuads> map;
      map.u = near + tz * across;
      map.du_dx = near_x + tz * (far_x - near_x);
      map.du_dy = near_y + tz * (far_y - near_y);
      map.du_dz = across;
      return map;
    }

    // Of the six tetrahedra around the cell's diagonal (Kuhn's) the one that holds t: from the
    // lowest corner along the axis of the largest component, then of the next, then of the last. So
    // the derivatives are edges of the cell, as the bounds of injection() are of.
    [[gnu::always_inline]] Map<kQuads> in_tetrahedron(const char* const* lowest, F t) const {
      const I of = rank<kQuads>(t);
      const I to_second = quads::sum_ints<kQuads>(steps_ & (of == 0));
      const I to_third = quads::sum_ints<kQuads>(steps_ & (of <= 1));
      const char* second[kQuads];
      const char* third[kQuads];
      for (int q = 0; q < kQuads; ++q) {
        second[q] = lowest[q] + to_second[4 * q];
        third[q] = lowest[q] + to_third[4 * q];
      }
      const F a = quads::load(lowest, 0, F{});
      const F b = quads::load(second, 0, F{});
      const F c = quads::load(third, 0, F{});
      const F first = b - a;
      const F middle = c - b;
      const F last = quads::load(lowest, step_x_ + step_y_ + step_z_, F{}) - c;
      const I x = quads::swizzle_ints<0, 0, 0, kQuads>(of);
      const I y = quads::swizzle_ints<1, 1, 1, kQuads>(of);
      const I z = quads::swizzle_ints<2, 2, 2, kQuads>(of);
      Map<kQuads> map;
      map.du_dx = x == 0 ? first : x == 1 ? middle : last;
      map.du_dy = y == 0 ? first : y == 1 ? middle : last;
      map.du_dz = z == 0 ? first : z == 1 ? middle : last;
      map.u = a + quads::swizzle<0, 0, 0, kQuads>(t) * map.du_dx +
              quads::swizzle<1, 1, 1, kQuads>(t) * map.du_dy +
              quads::swizzle<2, 2, 2, kQuads>(t) * map.du_dz;
      map.rank = of;
      return map;
    }

    const char* u_;
    std::ptrdiff_t step_x_;
    std::ptrdiff_t step_y_;
    std::ptrdiff_t step_z_;
    F last_;
    F last_cell_;
    I strides_;
    I steps_;
  };

 private:
  VoxelBox elements_;
  glm::ivec3 common_voxels_{0};
  int width_ = 0;
  int height_ = 0;
  int depth_ = 0;
  std::ptrdiff_t step_x_ = 0;  // bytes; 0 where there is one element only
  std::ptrdiff_t step_y_ = 0;
  std::ptrdiff_t step_z_ = 0;
  glm::vec3 last_{0};       // element
  glm::vec3 last_cell_{0};  // its lowest corner
  std::vector<Float4> u_;
};

}  // namespace maille
