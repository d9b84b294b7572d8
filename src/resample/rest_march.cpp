#include "resample/rest_march.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille {
namespace {

using quads::all;
using quads::Floats;
using quads::Ints;

// What may be left of the way to an answer.
constexpr float kNearEnough_voxels = 1e-4f;
constexpr float kLongestStep_voxels = 2.0f;
constexpr int kMostSteps = 8;

// So long a step may be the last. Edges differ by twice the injection's share from one another, by
// that much along a cell: what is left after a step is the share of its square where it stays in
// one cell, twice the share of it where it does not. Of one that stays in its tetrahedron nothing.
struct LastSteps {
  float within_voxels;
  float anywhere_voxels;

  explicit LastSteps(double share)
      : within_voxels(static_cast<float>(std::sqrt(kNearEnough_voxels / std::max(share, 0.1)))),
        anywhere_voxels(static_cast<float>(kNearEnough_voxels / std::max(2.0 * share, 0.1))) {}
};

// One step of Newton's for as many voxels as a register holds; says which of them are there then.
template <CellMap kMap, int kQuads>
[[gnu::always_inline]] inline Ints<kQuads> newton_step(const DisplacementTile::Map<kQuads>& map,
                                                       const LastSteps& last, Floats<kQuads> target,
                                                       Floats<kQuads>& rest) {
  using F = Floats<kQuads>;
  const F x = map.du_dx + all<kQuads>(1.0f, 0.0f, 0.0f);
  const F y = map.du_dy + all<kQuads>(0.0f, 1.0f, 0.0f);
  const F z = map.du_dz + all<kQuads>(0.0f, 0.0f, 1.0f);
  const F off = target - (rest + map.u);
  const F yz = quads::cross<kQuads>(y, z);
  const F zx = quads::cross<kQuads>(z, x);
  const F xy = quads::cross<kQuads>(x, y);
  // By Cramer's rule, the determinant in the spare lane.
  const F unscaled = quads::sums<kQuads>(off * yz, off * zx, off * xy, x * yz);
  const F whole = unscaled / quads::swizzle<3, 3, 3, kQuads>(unscaled);
  const F length = quads::largest<kQuads>(whole);
  const F longest = all<kQuads>(kLongestStep_voxels);
  const F from_below = whole > -longest ? whole : -longest;
  const F step = from_below < longest ? from_below : longest;
  rest += step;
  const F t = map.t + step;
  const Ints<kQuads> within = (t >= 0.0f) & (t <= 1.0f);
  const Ints<kQuads> same_cell = within & quads::swizzle_ints<1, 2, 0, kQuads>(within) &
                                 quads::swizzle_ints<2, 0, 1, kQuads>(within);
  if constexpr (kMap == CellMap::tetrahedra) {
    const Ints<kQuads> same_rank = DisplacementTile::rank<kQuads>(t) == map.rank;
    const Ints<kQuads> same = same_cell & same_rank &
                              quads::swizzle_ints<1, 2, 0, kQuads>(same_rank) &
                              quads::swizzle_ints<2, 0, 1, kQuads>(same_rank);
    return (length <= last.anywhere_voxels) | same;
  } else {
    return (length <= last.anywhere_voxels) | ((length <= last.within_voxels) & same_cell);
  }
}

// Slow, but it arrives from anywhere.
template <CellMap kMap>
Float4 by_contraction(const DisplacementTile& tile, const glm::mat3& inverse, Float4 target) {
  constexpr int kMost = 400;
  constexpr float kLast_voxels = 2e-5f;
  const DisplacementTile::Reader<1> reader(tile);
  Float4 rest = target;
  for (int i = 0; i < kMost; ++i) {
    const Float4 off = target - (rest + reader.at<kMap>(rest).u);
    const glm::vec3 step = inverse * glm::vec3(off[0], off[1], off[2]);
    rest += Float4{step.x, step.y, step.z, 0.0f};
    if (std::max({std::abs(step.x), std::abs(step.y), std::abs(step.z)}) <= kLast_voxels) break;
  }
  return rest;
}

// A step for some voxels, and which of them are there then. There may be as many more behind the
// last of `targets` and `rest` as a register holds.
//
// In three loops, so that what is long under way is so for many voxels at a time: the next one
// would wait for all of it, since a machine looks only so many instructions ahead.
template <CellMap kMap, int kQuads>
[[gnu::always_inline]] inline void step_all(const DisplacementTile::Reader<kQuads>& reader,
                                            const LastSteps& last, const Float4* targets, int count,
                                            Float4* rest, Ints<1>* arrived) {
  using F = Floats<kQuads>;
  constexpr int kMost = kBrickEdge / kQuads;
  const auto load = [](const Float4* from, int i) __attribute__((always_inline)) {
    F lanes;
    __builtin_memcpy(&lanes, from + kQuads * i, sizeof lanes);
    return lanes;
  };
  typename DisplacementTile::Reader<kQuads>::Place places[kMost];
  DisplacementTile::Map<kQuads> maps[kMost];
  const int registers = (count + kQuads - 1) / kQuads;
  for (int i = 0; i < registers; ++i) places[i] = reader.place(load(rest, i));
  for (int i = 0; i < registers; ++i) {
    maps[i] = reader.template at<kMap>(load(rest, i), places[i]);
  }
  for (int i = 0; i < registers; ++i) {
    F at = load(rest, i);
    const Ints<kQuads> there = newton_step<kMap, kQuads>(maps[i], last, load(targets, i), at);
    __builtin_memcpy(rest + kQuads * i, &at, sizeof at);
    __builtin_memcpy(arrived + kQuads * i, &there, sizeof there);
  }
}

// rest: where to start from, then the answer; there may be as many more after `count` as a register
// holds. Step by step for all that are not there yet: after the first that is few.
template <CellMap kMap, int kQuads>
[[gnu::always_inline]] inline void march_row(const DisplacementTile& tile, const LastSteps& last,
                                             const glm::mat3& inverse, Float4 first, int count,
                                             Float4* rest) {
  const DisplacementTile::Reader<kQuads> reader(tile);
  constexpr int kMost = kBrickEdge + kQuads;
  Float4 targets[kMost];
  Ints<1> arrived[kMost];
  for (int x = 0; x < count + kQuads; ++x) {
    targets[x] = first + Float4{static_cast<float>(x), 0.0f, 0.0f, 0.0f};
  }
  step_all<kMap, kQuads>(reader, last, targets, count, rest, arrived);
  int waiting[kMost];
  int left = 0;
  for (int x = 0; x < count; ++x) {
    waiting[left] = x;
    left += arrived[x][0] == 0;
  }
  for (int i = 1; i < kMostSteps && left > 0; ++i) {
    Float4 targets_left[kMost];
    Float4 rest_left[kMost];
    // And the last one again to fill a register.
    for (int w = 0; w < left + kQuads - 1; ++w) {
      const int x = waiting[std::min(w, left - 1)];
      targets_left[w] = targets[x];
      rest_left[w] = rest[x];
    }
    step_all<kMap, kQuads>(reader, last, targets_left, left, rest_left, arrived);
    const int before = left;
    left = 0;
    for (int w = 0; w < before; ++w) {
      const int x = waiting[w];
      rest[x] = rest_left[w];
      waiting[left] = x;
      left += arrived[w][0] == 0;
    }
  }
  for (int w = 0; w < left; ++w) {
    rest[waiting[w]] = by_contraction<kMap>(tile, inverse, targets[waiting[w]]);
  }
}

template <int kQuads>
[[gnu::always_inline]] inline void march_trilinear(const DisplacementTile& tile,
                                                   const LastSteps& last, const glm::mat3& inverse,
                                                   Float4 first, int count, Float4* rest) {
  march_row<CellMap::trilinear, kQuads>(tile, last, inverse, first, count, rest);
}
MAILLE_ONE_OF_WIDTHS(void, march_trilinear_of, march_trilinear,
                     (const DisplacementTile& tile, const LastSteps& last, const glm::mat3& inverse,
                      Float4 first, int count, Float4* rest),
                     (tile, last, inverse, first, count, rest))

template <int kQuads>
[[gnu::always_inline]] inline void march_tetrahedra(const DisplacementTile& tile,
                                                    const LastSteps& last, const glm::mat3& inverse,
                                                    Float4 first, int count, Float4* rest) {
  march_row<CellMap::tetrahedra, kQuads>(tile, last, inverse, first, count, rest);
}
MAILLE_ONE_OF_WIDTHS(void, march_tetrahedra_of, march_tetrahedra,
                     (const DisplacementTile& tile, const LastSteps& last, const glm::mat3& inverse,
                      Float4 first, int count, Float4* rest),
                     (tile, last, inverse, first, count, rest))

}  // namespace

RestMarch::RestMarch(const DisplacementTile& tile, const DisplacementTile::Injection& injection,
                     const VoxelBox& voxels, CellMap map, Registers registers)
    : tile_(&tile),
      injection_(injection),
      extent_(voxels.size()),
      map_(map),
      registers_(registers) {
  const glm::vec3 first(voxels.lo - tile.elements().lo - tile.common_voxels());
  first_ = Float4{first.x, first.y, first.z, 0.0f};
  const auto count = static_cast<std::size_t>(extent_.x) * static_cast<std::size_t>(extent_.y);
  // And what fills the last register.
  for (auto& plane : planes_) plane.resize(count + 1);
}

const Float4* RestMarch::next_row() {
  const auto row_of = [&](int y, int z) {
    return &planes_[static_cast<std::size_t>(z & 1)]
                   [static_cast<std::size_t>(y) * static_cast<std::size_t>(extent_.x)];
  };
  const auto step_along = [&](int axis) {
    const glm::vec3 on = injection_.inverse[axis];
    return Float4{on.x, on.y, on.z, 0.0f};
  };
  Float4* const row = row_of(y_, z_);
  const Float4 first = first_ + Float4{0.0f, static_cast<float>(y_), static_cast<float>(z_), 0.0f};
  if (y_ > 0 && z_ > 0) {
    // As far on from the row before as in the plane before: the creases between cells are there
    // too.
    const Float4* const last = row_of(y_ - 1, z_);
    const Float4* const there = row_of(y_, z_ - 1);
    const Float4* const last_there = row_of(y_ - 1, z_ - 1);
    for (int x = 0; x < extent_.x; ++x) row[x] = last[x] + (there[x] - last_there[x]);
  } else if (y_ > 0 || z_ > 0) {
    const Float4* const last = y_ > 0 ? row_of(y_ - 1, z_) : row_of(y_, z_ - 1);
    const Float4 on = step_along(y_ > 0 ? 1 : 2);
    for (int x = 0; x < extent_.x; ++x) row[x] = last[x] + on;
  } else {
    row[0] = map_ == CellMap::trilinear
                 ? by_contraction<CellMap::trilinear>(*tile_, injection_.inverse, first)
                 : by_contraction<CellMap::tetrahedra>(*tile_, injection_.inverse, first);
    for (int x = 1; x < extent_.x; ++x) row[x] = row[x - 1] + step_along(0);
  }
  const bool widest = registers_ == Registers::widest;
  const auto march = map_ == CellMap::trilinear
                         ? (widest ? march_trilinear_of : march_trilinear_of_16)
                         : (widest ? march_tetrahedra_of : march_tetrahedra_of_16);
  march(*tile_, LastSteps(injection_.share), injection_.inverse, first, extent_.x, row);
  if (++y_ == extent_.y) {
    y_ = 0;
    ++z_;
  }
  return row;
}

std::optional<RestMarch> march_through(const Sight& sight, const VoxelBox& voxels,
                                       const TileMargin& margin) {
  // Writing it out takes longer than all else where material is squeezed: up to here less long than
  // to look for voxels from every cell.
  constexpr std::int64_t kMostElements = 96 * kBrickVoxels;
  constexpr double kSurely = 0.98;
  static thread_local DisplacementTile tile;
  const DeformedVolume& volume = sight.volume();
  if (sight.cut(voxels)) return std::nullopt;
  VoxelBox elements = sight.elements_over({voxels.lo - margin.voxels, voxels.hi + margin.voxels});
  elements = intersection({elements.lo - margin.elements, elements.hi + margin.elements},
                          {VoxelIndex(0), VoxelIndex(volume.size())});
  if (elements.empty() || voxel_count(elements.size()) > kMostElements) return std::nullopt;
  tile.fill(volume.lattice, elements);
  const bool at_border = glm::any(glm::equal(elements.lo, VoxelIndex(0))) ||
                         glm::any(glm::equal(elements.hi, VoxelIndex(volume.size())));
  const auto injection = tile.injection(at_border);
  if (!(injection.contraction() < kSurely)) return std::nullopt;
  return RestMarch(tile, injection, voxels, volume.cell_map);
}

}  // namespace maille
