// The displacements of a box of elements, written out: what a walk over voxels reads from, and what
// tells it that there is one answer for each.
//
// Between the elements, and beyond them as at the nearest, u is trilinear, and x(X) = X + u(X).
#pragma once

#include <vector>

#include "deform/lattice.h"
#include "resample/deformed_cell.h"
#include "resample/quads.h"

namespace maille {

class DisplacementTile {
 public:
  // Of no elements.
  DisplacementTile() = default;

  // elements: in the volume, not empty. Keeps its memory from one to the next.
  void fill(const Lattice& lattice, const VoxelBox& elements);

  const VoxelBox& elements() const { return elements_; }

  // x(X) - x(Y) is matrix (X - Y) for the middle of what the cells' edges allow, up to `share` of
  // its length (in the norm of the largest component, after the inverse): below 1 no two points of
  // the tile come to lie on one another, and x <- x + inverse (target - x(X)) comes nearer to the
  // one answer by that share each time. Whatever lies beyond the elements counts where
  // `with_beyond` says so.
  struct Injection {
    double share = 0.0;
    glm::mat3 inverse{1.0f};           // d X / d x
    glm::vec3 largest_cell_voxels{1};  // no cell's bounds are larger
  };
  Injection injection(bool with_beyond) const;

  // Far from rest floats would have no digits left for what matters: u is kept less so many whole
  // voxels, that are common to all. Where points lie now is less them too.
  glm::ivec3 common_voxels() const { return common_voxels_; }

  // u at the element (voxels, less what is common); x, y, z counted from the first.
  const Float4* row(int y, int z) const {
    return &u_[static_cast<std::size_t>((z * height_ + y) * width_)];
  }
  int width() const { return width_; }
  int height() const { return height_; }
  int depth() const { return depth_; }

  // Where points lie now, and how that changes with them. X: from the first element, in voxels.
  template <int kQuads>
  struct Map {
    quads::Floats<kQuads> u;
    quads::Floats<kQuads> du_dx, du_dy, du_dz;
    quads::Floats<kQuads> t;  // where in its cell; far away where it is beyond the elements
  };
  template <int kQuads>
  [[gnu::always_inline]] Map<kQuads> at(quads::Floats<kQuads> rest) const {
    using F = quads::Floats<kQuads>;
    using I = quads::Ints<kQuads>;
    const F last = quads::all<kQuads>(last_.x, last_.y, last_.z);
    const F last_cell = quads::all<kQuads>(last_cell_.x, last_cell_.y, last_cell_.z);
    const F below_last = rest < last ? rest : last;
    const F inside = below_last > 0.0f ? below_last : F{};
    const I base = __builtin_convertvector(inside < last_cell ? inside : last_cell, I);
    const F t = inside - __builtin_convertvector(base, F);
    const I strides = __builtin_convertvector(
        quads::all<kQuads>(1.0f, static_cast<float>(width_), static_cast<float>(width_ * height_)),
        I);
    const I part = base * strides;
    const I cell = part + quads::swizzle_ints<1, 2, 0, kQuads>(part) +
                   quads::swizzle_ints<2, 0, 1, kQuads>(part);
    const char* lowest[kQuads];
    for (int q = 0; q < kQuads; ++q) {
      lowest[q] = reinterpret_cast<const char*>(u_.data()) +
                  static_cast<std::ptrdiff_t>(sizeof(Float4)) * cell[4 * q];
    }
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
    // Beyond the elements u changes no more.
    const F within = inside == rest ? quads::all<kQuads>(1.0f) : F{};
    Map<kQuads> map;
    map.u = near + tz * across;
    map.du_dx = (near_x + tz * (far_x - near_x)) * quads::swizzle<0, 0, 0, kQuads>(within);
    map.du_dy = (near_y + tz * (far_y - near_y)) * quads::swizzle<1, 1, 1, kQuads>(within);
    map.du_dz = across * quads::swizzle<2, 2, 2, kQuads>(within);
    constexpr float kFar = 1e6f;
    map.t = inside == rest ? t : quads::all<kQuads>(kFar);
    return map;
  }

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
