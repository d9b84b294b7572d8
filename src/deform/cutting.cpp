#include "deform/cutting.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "deform/brick_corner.h"
#include "deform/cuts_edit.h"
#include "deform/lattice_reach.h"

namespace maille {
namespace {

// Links are tested against the triangles near them, in blocks that begin at 4^3 elements.
constexpr int kBlockEdge = 4;
constexpr std::int64_t kCutUnitsPerUnit = kCutUnitsPerVoxel / kUnitsPerVoxel;

CutPoint place_of(VoxelIndex voxel, glm::ivec3 u) {
  return CutPoint(voxel) * kCutUnitsPerVoxel + CutPoint(u) * kCutUnitsPerUnit;
}

SpaceBox space_box(const CutBounds& bounds) {
  return {glm::dvec3(bounds.lo) / double{kCutUnitsPerVoxel},
          glm::dvec3(bounds.hi) / double{kCutUnitsPerVoxel}};
}

CutBounds cut_bounds(const SpaceBox& box) {  // exact: elements lie at multiples of a cut unit
  return {CutPoint(box.lo * double{kCutUnitsPerVoxel}),
          CutPoint(box.hi * double{kCutUnitsPerVoxel})};
}

// The links that begin in a block of elements.
class LinkBlock {
 public:
  // first: counted from the brick's lowest element.
  LinkBlock(const BrickCorner& corner, VoxelIndex first)
      : first_(corner.box().lo + first),
        begin_(glm::min(corner.box().size() - first, Size3(kBlockEdge))),
        extent_(glm::min(corner.with_next().size() - first, Size3(kBlockEdge + 1))) {
    std::size_t i = 0;
    for (int z = 0; z < extent_.z; ++z) {
      for (int y = 0; y < extent_.y; ++y) {
        for (int x = 0; x < extent_.x; ++x, ++i) {
          const VoxelIndex in_block{x, y, z};
          places_[i] = place_of(first_ + in_block, corner.u(first + in_block));
          bounds_ = i == 0 ? CutBounds{places_[i], places_[i]}
                           : CutBounds{glm::min(bounds_.lo, places_[i]),
                                       glm::max(bounds_.hi, places_[i])};
        }
      }
    }
  }

  const CutBounds& bounds() const { return bounds_; }

  void cut(const CutTriangle& triangle, CutsEdit& edit) const {
    std::array<bool, kPlaces> above;
    const auto count = static_cast<std::size_t>(voxel_count(extent_));
    for (std::size_t i = 0; i < count; ++i) above[i] = triangle.above(places_[i]);
    if (std::all_of(above.begin(), above.begin() + static_cast<std::ptrdiff_t>(count),
                    [&](bool side) { return side == above[0]; })) {
      return;
    }
    for (int z = 0; z < begin_.z; ++z) {
      for (int y = 0; y < begin_.y; ++y) {
        for (int x = 0; x < begin_.x; ++x) {
          const VoxelIndex lower{x, y, z};
          const auto i = static_cast<std::size_t>(linear_index(lower, extent_));
          for (int axis = 0; axis < 3; ++axis) {
            VoxelIndex upper = lower;
            if (++upper[axis] >= extent_[axis]) continue;
            const auto j = static_cast<std::size_t>(linear_index(upper, extent_));
            if (above[i] != above[j] && triangle.pierced_by(places_[i], places_[j])) {
              edit.set_removed(first_ + lower, axis, true);
            }
          }
        }
      }
    }
  }

 private:
  static constexpr std::size_t kPlaces = (kBlockEdge + 1) * (kBlockEdge + 1) * (kBlockEdge + 1);

  VoxelIndex first_;
  Size3 begin_;   // of the elements whose links these are
  Size3 extent_;  // with the next ones
  std::array<CutPoint, kPlaces> places_;
  CutBounds bounds_;
};

void cut_brick(const BrickCorner& corner, const std::vector<const CutTriangle*>& triangles,
               CutsEdit& edit) {
  const Size3 extent = corner.box().size();
  for (int z = 0; z < extent.z; z += kBlockEdge) {
    for (int y = 0; y < extent.y; y += kBlockEdge) {
      for (int x = 0; x < extent.x; x += kBlockEdge) {
        const LinkBlock block(corner, {x, y, z});
        for (const CutTriangle* triangle : triangles) {
          if (triangle->may_touch(block.bounds())) block.cut(*triangle, edit);
        }
      }
    }
  }
}

}  // namespace

Result<Cuts> cut_along(const Cuts& cuts, const Lattice& lattice, const CutSurface& surface) {
  const Size3 size = lattice.grid().volume_size();
  if (std::max({size.x, size.y, size.z}) > kLongestCutAxis_voxels) {
    return Error{ErrorKind::usage, "cut: expected a volume of at most " +
                                       std::to_string(kLongestCutAxis_voxels) +
                                       " voxels along an axis"};
  }
  CutsEdit edit(cuts);
  BrickCorner corner;
  std::vector<const CutTriangle*> near;
  for (const std::int64_t b : bricks_with_links_in(space_box(surface.bounds()), lattice)) {
    const CutBounds bounds = cut_bounds(bounds_of_links(lattice, b));
    near.clear();
    for (const CutTriangle& triangle : surface.triangles()) {
      if (triangle.may_touch(bounds)) near.push_back(&triangle);
    }
    if (near.empty()) continue;
    corner.read(lattice, b);
    cut_brick(corner, near, edit);
  }
  return edit.finish();
}

}  // namespace maille
