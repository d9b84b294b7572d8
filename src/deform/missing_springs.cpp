#include "deform/missing_springs.h"

#include <algorithm>
#include <array>

namespace maille {
namespace {

using AxisBits = std::uint8_t;  // a bit an axis

// A brick and one element around it.
constexpr int kHaloEdge = kBrickEdge + 2;
constexpr int halo_index(int x, int y, int z) {  // of an element of the brick itself
  return ((z + 1) * kHaloEdge + y + 1) * kHaloEdge + x + 1;
}

// Steps to the next element of a halo array.
constexpr std::array<int, 3> kStep = {1, kHaloEdge, kHaloEdge* kHaloEdge};

bool any_cut_near(const Cuts& cuts, BrickIndex brick) {
  for (int z = -1; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        const BrickIndex there = brick + BrickIndex(x, y, z);
        if (cuts.grid().contains(there) && cuts.brick(cuts.grid().linear(there))) return true;
      }
    }
  }
  return false;
}

// Which links of the elements of a brick and of those around it are removed, by lower element.
std::vector<AxisBits> removed_around(const Cuts& cuts, VoxelIndex lowest) {
  std::vector<AxisBits> removed(std::size_t{kHaloEdge} * kHaloEdge * kHaloEdge);
  std::size_t i = 0;
  for (int z = -1; z <= kBrickEdge; ++z) {
    for (int y = -1; y <= kBrickEdge; ++y) {
      for (int x = -1; x <= kBrickEdge; ++x, ++i) {
        const VoxelIndex voxel = lowest + VoxelIndex(x, y, z);
        if (!contains(cuts.grid().volume_size(), voxel)) continue;
        for (int axis = 0; axis < 3; ++axis) {
          if (cuts.removed(voxel, axis)) removed[i] |= static_cast<AxisBits>(1 << axis);
        }
      }
    }
  }
  return removed;
}

// A step from an element along an axis, up or down.
struct Step {
  int axis = 0;
  int halo_step = 0;

  bool removed(const AxisBits* links, int from) const {
    return (links[std::min(from, from + halo_step)] >> axis) & 1;
  }
};

// One way along an axis, or a first and a second one, to be taken in either order.
struct Way {
  std::array<Step, 2> steps;
  int count = 0;

  explicit Way(const Spring& spring) {
    for (int axis = 0; axis < 3; ++axis) {
      if (spring.offset[axis] == 0) continue;
      steps[static_cast<std::size_t>(count++)] = {
          axis, spring.offset[axis] * kStep[static_cast<std::size_t>(axis)]};
    }
  }

  bool broken(const AxisBits* links, int from) const {
    const auto& [first, second] = steps;
    if (count == 1) return first.removed(links, from);
    return (first.removed(links, from) || second.removed(links, from + first.halo_step)) &&
           (second.removed(links, from) || first.removed(links, from + second.halo_step));
  }
};

}  // namespace

std::vector<std::uint32_t> missing_springs(const Cuts& cuts, std::int64_t brick,
                                           const Springs& springs) {
  const BrickIndex index = cuts.grid().brick(brick);
  if (!any_cut_near(cuts, index)) return {};
  const VoxelBox box = cuts.grid().box(index);
  const std::vector<AxisBits> links = removed_around(cuts, box.lo);
  const std::vector<Way> ways(springs.begin(), springs.end());
  std::vector<std::uint32_t> missing(kBrickVoxels);
  std::uint32_t any = 0;
  for (int z = 0; z < box.size().z; ++z) {
    for (int y = 0; y < box.size().y; ++y) {
      for (int x = 0; x < box.size().x; ++x) {
        std::uint32_t& bits = missing[static_cast<std::size_t>(element_in_brick({x, y, z}))];
        for (std::size_t s = 0; s < ways.size(); ++s) {
          if (ways[s].broken(links.data(), halo_index(x, y, z))) bits |= std::uint32_t{1} << s;
        }
        any |= bits;
      }
    }
  }
  return any ? missing : std::vector<std::uint32_t>{};
}

}  // namespace maille
