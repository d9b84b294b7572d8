// Deformed lattices and what is left of their links, plainly, for the tests of this room.
#pragma once

#include <algorithm>
#include <random>
#include <vector>

#include "deform/cuts.h"
#include "deform/lattice.h"

namespace maille::testing {

template <class F>
void for_each_voxel(Size3 size, F&& f) {
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) f(VoxelIndex(x, y, z));
    }
  }
}

// u of each voxel, x fastest.
inline Lattice lattice_of(Size3 size, const std::vector<glm::ivec3>& u) {
  Lattice lattice(size);
  const BrickGrid& grid = lattice.grid();
  for (std::int64_t b = 0; b < grid.count(); ++b) {
    auto brick = std::make_unique<BrickDisplacements>();
    const VoxelBox box = grid.box(grid.brick(b));
    for_each_voxel(box.size(), [&](VoxelIndex in_box) {
      const VoxelIndex v = box.lo + in_box;
      for (int c = 0; c < 3; ++c) {
        brick->u[c][element_in_brick(v)] = u[static_cast<std::size_t>(linear_index(v, size))][c];
      }
    });
    lattice.set(b, LatticeBrick::create(box, *brick));
  }
  return lattice;
}

// Displaced at random by up to `most` fixed-point units, but for a share of bricks at rest.
inline Lattice random_lattice(Size3 size, int most, double at_rest, std::mt19937& random) {
  std::uniform_int_distribution<int> u(-most, most);
  std::uniform_real_distribution<double> share;
  const BrickGrid grid(size);
  std::vector<char> rests(static_cast<std::size_t>(grid.count()));
  for (char& r : rests) r = share(random) < at_rest;
  std::vector<glm::ivec3> all(static_cast<std::size_t>(voxel_count(size)));
  for_each_voxel(size, [&](VoxelIndex v) {
    if (rests[static_cast<std::size_t>(grid.linear(BrickGrid::brick_of(v)))]) return;
    all[static_cast<std::size_t>(linear_index(v, size))] = {u(random), u(random), u(random)};
  });
  return lattice_of(size, all);
}

inline glm::dvec3 place_of(const Lattice& lattice, VoxelIndex voxel) {
  return glm::dvec3(voxel) + lattice.displacement_voxels(voxel);
}

// Calls f(lower, axis, upper).
template <class F>
void for_each_link_of(Size3 size, F&& f) {
  for_each_voxel(size, [&](VoxelIndex lower) {
    for (int axis = 0; axis < 3; ++axis) {
      VoxelIndex upper = lower;
      if (++upper[axis] < size[axis]) f(lower, axis, upper);
    }
  });
}

inline std::int64_t removed_links(const Cuts& cuts) {
  std::int64_t count = 0;
  for_each_link_of(cuts.grid().volume_size(), [&](VoxelIndex lower, int axis, VoxelIndex) {
    count += cuts.removed(lower, axis);
  });
  return count;
}

// Whether no carved element has a link, and no link that would leave the volume is called removed.
inline bool consistent(const Cuts& cuts) {
  const Size3 size = cuts.grid().volume_size();
  bool good = true;
  for_each_link_of(size, [&](VoxelIndex lower, int axis, VoxelIndex upper) {
    good = good && (cuts.removed(lower, axis) || (!cuts.carved(lower) && !cuts.carved(upper)));
  });
  for_each_voxel(size, [&](VoxelIndex v) {
    for (int axis = 0; axis < 3; ++axis) {
      good = good && !(v[axis] == size[axis] - 1 && cuts.removed(v, axis));
    }
  });
  return good;
}

// The number of the piece that each element belongs to, following the links that are left.
inline std::vector<int> pieces(const Cuts& cuts) {
  const Size3 size = cuts.grid().volume_size();
  std::vector<int> piece(static_cast<std::size_t>(voxel_count(size)), -1);
  const auto at = [&](VoxelIndex v) -> int& {
    return piece[static_cast<std::size_t>(linear_index(v, size))];
  };
  int count = 0;
  for_each_voxel(size, [&](VoxelIndex seed) {
    if (at(seed) >= 0) return;
    at(seed) = count;
    std::vector<VoxelIndex> open{seed};
    const auto reach = [&](VoxelIndex v) {
      if (at(v) < 0) {
        at(v) = count;
        open.push_back(v);
      }
    };
    while (!open.empty()) {
      const VoxelIndex v = open.back();
      open.pop_back();
      for (int axis = 0; axis < 3; ++axis) {
        VoxelIndex next = v;
        VoxelIndex before = v;
        if (++next[axis] < size[axis] && !cuts.removed(v, axis)) reach(next);
        if (--before[axis] >= 0 && !cuts.removed(before, axis)) reach(before);
      }
    }
    ++count;
  });
  return piece;
}

}  // namespace maille::testing
