// Lattices, volumes and cuts from formulas.
#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "resample/resampler.h"

namespace maille::testing {

using Field = std::function<glm::dvec3(glm::dvec3)>;  // displacement (voxels) of a rest position

inline Lattice lattice_from(Size3 size, const Field& u) {
  Lattice lattice(size);
  const BrickGrid& grid = lattice.grid();
  for (std::int64_t b = 0; b < grid.count(); ++b) {
    auto brick = std::make_unique<BrickDisplacements>();
    const VoxelBox box = grid.box(grid.brick(b));
    for (int z = box.lo.z; z < box.hi.z; ++z) {
      for (int y = box.lo.y; y < box.hi.y; ++y) {
        for (int x = box.lo.x; x < box.hi.x; ++x) {
          const glm::dvec3 move = u({x, y, z}) * double{kUnitsPerVoxel};
          for (int c = 0; c < 3; ++c) {
            brick->u[c][element_in_brick({x, y, z})] = static_cast<int>(std::lround(move[c]));
          }
        }
      }
    }
    lattice.set(b, LatticeBrick::create(box, *brick));
  }
  return lattice;
}

template <class T>
Volume volume_from(Size3 size, VoxelType type, glm::dvec3 spacing_mm,
                   const std::function<double(VoxelIndex)>& value) {
  std::vector<T> samples;
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) samples.push_back(static_cast<T>(value({x, y, z})));
    }
  }
  return Volume::of(size, type, axis_aligned(spacing_mm), std::move(samples));
}

// Every voxel its own value, so that a wrong element shows.
inline Volume numbered(Size3 size, glm::dvec3 spacing_mm = glm::dvec3(1)) {
  return volume_from<float>(size, VoxelType::float32, spacing_mm, [&](VoxelIndex v) {
    return static_cast<double>(linear_index(v, size));
  });
}

template <class F>
void for_each_voxel(Size3 size, F&& f) {
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) f(VoxelIndex(x, y, z));
    }
  }
}

// Cuts bit by bit, as cuts.h promises them: a carved element has none of its six links.
class CutsByHand {
 public:
  explicit CutsByHand(Size3 size) : cuts_(size) {}

  void remove(VoxelIndex lower, int axis) {
    VoxelIndex upper = lower;
    ++upper[axis];
    const Size3 size = cuts_.grid().volume_size();
    if (!contains(size, lower) || !contains(size, upper)) return;
    set(brick(lower).removed[static_cast<std::size_t>(axis)], lower);
  }
  void carve(VoxelIndex element) {
    set(brick(element).carved, element);
    for (int axis = 0; axis < 3; ++axis) {
      VoxelIndex lower = element;
      --lower[axis];
      remove(element, axis);
      remove(lower, axis);
    }
  }
  // All links from x to x + 1 for which `where` holds.
  void cut_across_x(int x, const std::function<bool(VoxelIndex)>& where = {}) {
    const Size3 size = cuts_.grid().volume_size();
    for_each_voxel({1, size.y, size.z}, [&](VoxelIndex v) {
      v.x = x;
      if (!where || where(v)) remove(v, 0);
    });
  }
  // All links between what a predicate holds for and what it does not.
  void part(const std::function<bool(VoxelIndex)>& inside) {
    for_each_voxel(cuts_.grid().volume_size(), [&](VoxelIndex v) {
      for (int axis = 0; axis < 3; ++axis) {
        VoxelIndex next = v;
        ++next[axis];
        if (inside(v) != inside(next)) remove(v, axis);
      }
    });
  }

  Cuts done() const {
    Cuts cuts = cuts_;
    for (const auto& [linear, brick] : bricks_) {
      cuts.set(linear, std::make_shared<const CutBrick>(*brick));
    }
    return cuts;
  }

 private:
  CutBrick& brick(VoxelIndex voxel) {
    auto& b = bricks_[cuts_.grid().linear(BrickGrid::brick_of(voxel))];
    if (!b) b = std::make_unique<CutBrick>();
    return *b;
  }
  static void set(CutBrick::Rows& rows, VoxelIndex voxel) {
    const auto e = static_cast<std::size_t>(element_in_brick(voxel));
    rows[e / kBrickEdge] |= std::uint32_t{1} << (e % kBrickEdge);
  }

  Cuts cuts_;
  std::map<std::int64_t, std::unique_ptr<CutBrick>> bricks_;
};

}  // namespace maille::testing
