#include "deform/brick_slack.h"

#include <algorithm>

#include "core/several_widths.h"

namespace maille {
namespace {

// floor((a + b) / 2) without the carry getting lost.
template <class L>
[[gnu::always_inline]] inline L mean(L a, L b) {
  return static_cast<L>((a & b) + ((a ^ b) >> 1));
}

template <class L>
[[gnu::always_inline]] inline L clamped(std::int64_t slack) {
  return static_cast<L>(
      std::clamp<std::int64_t>(slack, 0, std::int64_t{std::numeric_limits<L>::max()}));
}

// 32 links whose ends have limits a and b and differ by `stretch` units (along the drag).
template <class L>
[[gnu::always_inline]] inline void slack_row(const L* a, const L* b, const std::int32_t* stretch,
                                             std::int32_t sense, L* out) {
  for (int x = 0; x < kBrickEdge; ++x) {
    if constexpr (sizeof(L) == 2) {
      // Differences stay far below 2^31 and limits below 2^16.
      const std::int32_t slack = std::int32_t{mean(a[x], b[x])} + sense * stretch[x];
      out[x] = static_cast<L>(std::clamp<std::int32_t>(slack, 0, std::numeric_limits<L>::max()));
    } else {
      out[x] = clamped<L>(std::int64_t{mean(a[x], b[x])} + sense * std::int64_t{stretch[x]});
    }
  }
}

template <class L>
[[gnu::always_inline]] inline void mean_row(const L* a, const L* b, L* out) {
  for (int x = 0; x < kBrickEdge; ++x) out[x] = mean(a[x], b[x]);
}

// The loader chooses among plain functions only.
MAILLE_FOR_SEVERAL_WIDTHS void slack_of(const std::uint16_t* a, const std::uint16_t* b,
                                        const std::int32_t* stretch, std::int32_t sense,
                                        std::uint16_t* out) {
  slack_row(a, b, stretch, sense, out);
}
MAILLE_FOR_SEVERAL_WIDTHS void slack_of(const std::uint32_t* a, const std::uint32_t* b,
                                        const std::int32_t* stretch, std::int32_t sense,
                                        std::uint32_t* out) {
  slack_row(a, b, stretch, sense, out);
}
MAILLE_FOR_SEVERAL_WIDTHS void means_of(const std::uint16_t* a, const std::uint16_t* b,
                                        std::uint16_t* out) {
  mean_row(a, b, out);
}
MAILLE_FOR_SEVERAL_WIDTHS void means_of(const std::uint32_t* a, const std::uint32_t* b,
                                        std::uint32_t* out) {
  mean_row(a, b, out);
}

// A limit of each element of a row; most rows are of one material.
template <class L>
void look_up(const std::array<L, kMaxMaterials>& limit, const MaterialId* ids, int count, L* out) {
  const MaterialId first = ids[0];
  if (std::all_of(ids + 1, ids + count, [&](MaterialId id) { return id == first; })) {
    std::fill_n(out, kBrickEdge, limit[first]);
    return;
  }
  for (int x = 0; x < count; ++x) out[x] = limit[ids[x]];
  std::fill(out + count, out + kBrickEdge, L{0});
}

template <class L>
void remove(std::uint32_t bits, L* slack) {
  for (; bits != 0; bits &= bits - 1) slack[__builtin_ctz(bits)] = BrickSlack<L>::kRemoved;
}

void read_row(const DisplacementPlane* plane, int row, std::int32_t sign, std::int32_t* u) {
  if (!plane) {
    std::fill_n(u, kBrickEdge, 0);
    return;
  }
  plane->read_row(row * kBrickEdge, kBrickEdge, u);
  for (int x = 0; x < kBrickEdge; ++x) u[x] *= sign;
}

bool constant(const DisplacementPlane* plane) { return !plane || plane->constant(); }
std::int32_t constant_of(const DisplacementPlane* plane) { return plane ? plane->at(0) : 0; }

}  // namespace

template <class L>
DirectedLimits<L>::DirectedLimits(const MaterialTable& table, int drag_component, bool downwards)
    : component(drag_component), sign(downwards ? -1 : 1) {
  for (int i = 0; i < table.count(); ++i) {
    const auto m = static_cast<std::size_t>(i);
    const ElementLimits& own = table.limits(static_cast<MaterialId>(i));
    shorten[m] = static_cast<L>(own.compress[component]);
    lengthen[m] = static_cast<L>(own.stretch[component]);
    slip[m] = static_cast<L>(own.shear[component]);
    if (downwards) std::swap(shorten[m], lengthen[m]);
  }
}

template <class L>
void BrickSlack<L>::begin(const StrokeBricks& bricks, const StrokeBrick& brick,
                          const Lattice& start, const DirectedLimits<L>& limits) {
  brick_ = &brick;
  limits_ = &limits;
  const int c = limits.component;
  const BrickGrid& grid = bricks.grid();
  const auto plane_of = [&](std::int64_t linear) -> const DisplacementPlane* {
    const LatticeBrick* b = start.brick(linear);
    return b ? b->plane(c).get() : nullptr;
  };
  here_ = plane_of(brick.linear);
  const bool any_cuts = !bricks.cuts().empty();
  cut_ = any_cuts ? bricks.cuts().brick(brick.linear) : nullptr;
  uniform_ = brick.uniform && constant(here_) && !cut_;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    cut_before_[a] = nullptr;
    if (brick.uniform) {
      const bool along = axis == c;
      one_up_[a] = (along ? limits.shorten : limits.slip)[*brick.uniform];
      one_down_[a] = (along ? limits.lengthen : limits.slip)[*brick.uniform];
    }
    for (const int side : {-1, 1}) {
      const std::size_t s = 2 * a + (side > 0);
      BrickIndex next = brick.index;
      next[axis] += side;
      beside_[s] = nullptr;
      if (!grid.contains(next)) continue;
      const std::int64_t linear = grid.linear(next);
      beside_[s] = plane_of(linear);
      if (side < 0 && any_cuts) cut_before_[a] = bricks.cuts().brick(linear);
      crossing_uniform_[s] = uniform_ && constant(beside_[s]) &&
                             constant_of(beside_[s]) == constant_of(here_) &&
                             !(side < 0 && cut_before_[a]);
    }
  }
  if (uniform_) return;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!up_[axis]) up_[axis] = make_aligned_array<L>(kBrickVoxels);
    if (!down_[axis]) down_[axis] = make_aligned_array<L>(kBrickVoxels);
  }
  ready_.fill(false);
}

// A limit of each of `count` elements from a voxel on along x.
template <class L>
void BrickSlack<L>::limits_from(VoxelIndex voxel, int count,
                                const std::array<L, kMaxMaterials>& limit, L* out) const {
  if (brick_->uniform) {
    std::fill_n(out, kBrickEdge, limit[*brick_->uniform]);
  } else {
    look_up(limit, brick_->row(voxel), count, out);
  }
}

template <class L>
void BrickSlack<L>::fill(int y, int z) {
  const auto row = static_cast<std::size_t>(z * kBrickEdge + y);
  ready_[row] = true;
  const Size3 extent = brick_->box.size();
  const VoxelIndex first = brick_->box.lo + VoxelIndex(0, y, z);
  const int c = limits_->component;
  alignas(64) std::int32_t u[kBrickEdge];
  const bool moved = !constant(here_);
  if (moved) read_row(here_, static_cast<int>(row), limits_->sign, u);
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    L* up = &up_[a][row * kBrickEdge];
    L* down = &down_[a][row * kBrickEdge];
    VoxelIndex step(0);
    step[axis] = 1;
    if (axis > 0 && VoxelIndex(0, y, z)[axis] + 1 >= extent[axis]) {
      continue;  // these cross the side, or there are none
    }
    // The last link along x crosses the side too; its lane is never read.
    const int count = axis == 0 ? extent.x - 1 : extent.x;
    if (count <= 0) continue;
    alignas(64) std::int32_t stretch[kBrickEdge];
    if (moved) {
      if (axis == 0) {
        for (int x = 0; x + 1 < kBrickEdge; ++x) stretch[x] = u[x + 1] - u[x];
        stretch[kBrickEdge - 1] = 0;
      } else {
        alignas(64) std::int32_t next[kBrickEdge];
        read_row(here_, static_cast<int>(row) + (axis == 1 ? 1 : kBrickEdge), limits_->sign, next);
        for (int x = 0; x < kBrickEdge; ++x) stretch[x] = next[x] - u[x];
      }
    }
    const auto slack = [&](const std::array<L, kMaxMaterials>& limit, std::int32_t sense, L* out) {
      alignas(64) L own[kBrickEdge];
      alignas(64) L next[kBrickEdge];
      limits_from(first, count, limit, own);
      limits_from(first + step, count, limit, next);
      if (moved) {
        slack_of(own, next, stretch, sense, out);
      } else {
        means_of(own, next, out);
      }
    };
    const bool along = axis == c;
    slack(along ? limits_->shorten : limits_->slip, 1, up);
    if (along || moved) {
      slack(along ? limits_->lengthen : limits_->slip, -1, down);
    } else {
      std::copy_n(up, kBrickEdge, down);
    }
    if (cut_) {
      const std::uint32_t removed = cut_->removed[a][row];
      remove(removed, up);
      remove(removed, down);
    }
  }
}

template <class L>
void BrickSlack<L>::cross(int axis, int side, int line, Crossing& crossing) const {
  const auto a = static_cast<std::size_t>(axis);
  const std::size_t s = 2 * a + (side > 0);
  // On the low side the neighbour holds the lower element of the link.
  L* const up = side < 0 ? crossing.into : crossing.out_of;
  L* const down = side < 0 ? crossing.out_of : crossing.into;
  if (crossing_uniform_[s]) {
    std::fill_n(up, kBrickEdge, one_up_[a]);
    std::fill_n(down, kBrickEdge, one_down_[a]);
    return;
  }
  const VoxelBox& box = brick_->box;
  const int run = axis == 0 ? 1 : 0;  // the axis along which the 32 links lie
  VoxelIndex own = box.lo;
  own[axis == 2 ? 1 : 2] += line;
  own[axis] = side < 0 ? box.lo[axis] : box.hi[axis] - 1;
  VoxelIndex beside = own;
  beside[axis] += side;
  const int count = box.size()[run];

  const DisplacementPlane* own_plane = here_;
  const DisplacementPlane* beside_plane = beside_[s];
  alignas(64) std::int32_t stretch[kBrickEdge] = {};
  if (own_plane || beside_plane) {
    alignas(64) std::int32_t own_u[kBrickEdge] = {};
    alignas(64) std::int32_t beside_u[kBrickEdge] = {};
    if (run == 0) {
      read_row(own_plane, element_in_brick(own) / kBrickEdge, limits_->sign, own_u);
      read_row(beside_plane, element_in_brick(beside) / kBrickEdge, limits_->sign, beside_u);
    } else {
      for (int i = 0; i < count; ++i) {
        const int step = i * kBrickEdge;
        if (own_plane) own_u[i] = limits_->sign * own_plane->at(element_in_brick(own) + step);
        if (beside_plane) {
          beside_u[i] = limits_->sign * beside_plane->at(element_in_brick(beside) + step);
        }
      }
    }
    for (int i = 0; i < kBrickEdge; ++i) {
      stretch[i] = side < 0 ? own_u[i] - beside_u[i] : beside_u[i] - own_u[i];
    }
  }
  const auto limits_of = [&](VoxelIndex voxel, const std::array<L, kMaxMaterials>& limit, L* out) {
    if (brick_->uniform || run == 0) {
      limits_from(voxel, count, limit, out);
      return;
    }
    std::fill_n(out, kBrickEdge, L{0});
    for (int i = 0; i < count; ++i, ++voxel[run]) out[i] = limit[*brick_->row(voxel)];
  };
  const auto slack = [&](const std::array<L, kMaxMaterials>& limit, std::int32_t sense, L* out) {
    alignas(64) L own_limit[kBrickEdge];
    alignas(64) L beside_limit[kBrickEdge];
    limits_of(own, limit, own_limit);
    limits_of(beside, limit, beside_limit);
    slack_of(own_limit, beside_limit, stretch, sense, out);
  };
  const bool along = axis == limits_->component;
  slack(along ? limits_->shorten : limits_->slip, 1, up);
  slack(along ? limits_->lengthen : limits_->slip, -1, down);

  // A link belongs to its lower element.
  const CutBrick* const cut = side < 0 ? cut_before_[a] : cut_;
  if (!cut) return;
  VoxelIndex lower = side < 0 ? beside : own;
  for (int i = 0; i < count; ++i, ++lower[run]) {
    const auto e = static_cast<std::size_t>(element_in_brick(lower));
    if (!((cut->removed[a][e / kBrickEdge] >> (e % kBrickEdge)) & 1)) continue;
    up[i] = kRemoved;
    down[i] = kRemoved;
  }
}

template class BrickSlack<std::uint16_t>;
template class BrickSlack<std::uint32_t>;
template struct DirectedLimits<std::uint16_t>;
template struct DirectedLimits<std::uint32_t>;

}  // namespace maille
