#include "resample/nearest_search.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "volume/brick.h"

namespace maille {
namespace {

using quads::all;
using quads::Floats;
using quads::Ints;
using Int4 = Ints<1>;

// What floats leave open, of the injection and of distances.
constexpr double kSlack = 1e-4;
// And of where points were at rest.
constexpr float kSlack_voxels = 2e-4f;
// Of what has no bound; its square is a float too.
constexpr float kFar = 1e18f;

// (1 - B)^-1 m. That inverse has no negative component just where B's spectral radius is below 1.
Float4 reach_of(const DisplacementTile::Injection& injection, glm::vec3 spacing_mm) {
  const Float4 far{kFar, kFar, kFar, 0.0f};
  if (!std::isfinite(injection.share)) return far;
  const glm::dmat3 inverse = glm::inverse(glm::dmat3(1.0) - (1.0 + kSlack) * injection.spread);
  glm::dvec3 row_lengths(0.0);
  for (int c = 0; c < 3; ++c) {
    glm::dvec3 row;
    for (int axis = 0; axis < 3; ++axis) {
      row[axis] = double{injection.inverse[axis][c]} / double{spacing_mm[axis]};
      if (!(inverse[axis][c] >= 0.0)) return far;
    }
    row_lengths[c] = glm::length(row);
  }
  const auto reach = glm::vec3(inverse * row_lengths * (1.0 + kSlack));
  if (!(std::max({reach.x, reach.y, reach.z}) < kFar)) return far;
  return Float4{reach.x, reach.y, reach.z, 0.0f};
}

[[gnu::always_inline]] inline Float4 nearest_whole(Float4 value) {
  const Float4 one_and_a_half_times_2_to_23 = splat(12582912.0f);
  return (value + one_and_a_half_times_2_to_23) - one_and_a_half_times_2_to_23;
}

[[gnu::always_inline]] inline Float4 floor(Float4 value) {
  const Float4 whole = nearest_whole(value);
  return whole > value ? whole - 1.0f : whole;
}

[[gnu::always_inline]] inline Float4 ceil(Float4 value) {
  const Float4 whole = nearest_whole(value);
  return whole < value ? whole + 1.0f : whole;
}

Float4 float4(VoxelIndex at) {
  return Float4{static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z), 0.0f};
}

bool all_of(Int4 v) { return (v[0] & v[1] & v[2]) != 0; }

}  // namespace

int NearestSearch::around_voxels(const DisplacementTile::Injection& injection,
                                 glm::vec3 spacing_mm) {
  if (!(reach_of(injection, spacing_mm)[0] < kFar)) return std::numeric_limits<int>::max();
  // A point is no further from some corner of its cell than half the diagonal of the cell's bounds.
  const float furthest_mm = glm::length(0.5f * injection.largest_cell_voxels * spacing_mm);
  const float most = furthest_mm / std::min({spacing_mm.x, spacing_mm.y, spacing_mm.z});
  constexpr float kMost = 1e6f;
  return static_cast<int>(std::min(most, kMost)) + 1;
}

NearestSearch::NearestSearch(const DisplacementTile& tile,
                             const DisplacementTile::Injection& injection, glm::vec3 spacing_mm,
                             std::int64_t points, Registers registers)
    : tile_(tile),
      registers_(registers),
      spacing_mm_{spacing_mm.x, spacing_mm.y, spacing_mm.z, 0.0f},
      reach_(reach_of(injection, spacing_mm)) {
  const VoxelIndex last = tile.elements().size() - 1;
  last_ = float4(last);
  // Where there is much more material than points, the bounds of blocks cost more than they save.
  constexpr std::int64_t kMostElements = 6;
  const bool by_blocks = voxel_count(tile.elements().size()) <= kMostElements * points;
  if (by_blocks) {
    edges_.emplace(tile);
    const Float4 far{kFar, kFar, kFar, 0.0f};
    blocks_.resize(static_cast<std::size_t>(voxel_count(edges_->size())),
                   Block{far * far, far, {}, {}});
  } else {
    blocks_.push_back({reach_ * reach_, reach_, Float4{}, last_});
  }
  const Size3 size = by_blocks ? edges_->size() : Size3(0);
  constexpr auto kBlockBytes = static_cast<int>(sizeof(Block));
  const glm::ivec3 strides(1, tile.width(), tile.width() * tile.height());
  corners_ = {reinterpret_cast<const char*>(tile.row(0, 0)),
              reinterpret_cast<const char*>(blocks_.data()),
              {},
              spacing_mm,
              glm::vec3(last),
              glm::vec3(glm::max(last - 1, VoxelIndex(0))),
              strides,
              kBlockBytes * glm::ivec3(by_blocks ? 1 : 0, size.x, size.x * size.y)};
  for (unsigned k = 0; k < 8; ++k) {
    const VoxelIndex at = glm::min(VoxelIndex(k & 1u, k >> 1 & 1u, k >> 2), last);
    const glm::ivec3 steps = at * strides;
    corners_.steps[k] = static_cast<std::ptrdiff_t>(sizeof(Float4)) * (steps.x + steps.y + steps.z);
  }
}

namespace {

// Of the eight lanes of both in each quad, in all of its lanes.
template <int kQuads>
[[gnu::always_inline]] inline Floats<kQuads> least_of_all(Floats<kQuads> a, Floats<kQuads> b) {
  using F = Floats<kQuads>;
  for (int i = 0; i < 3; ++i) {
    const F first = quads::interleaved<0, kQuads>(a, b);
    const F last = quads::interleaved<2, kQuads>(a, b);
    a = first < last ? first : last;
    b = a;
  }
  return a;
}

// Most often it is one of those around the point at rest: all eight at once, without a branch that
// depends on where in its cell the point is.
template <int kQuads>
[[gnu::always_inline]] inline void among_corners_of(const NearestSearch::Corners& corners,
                                                    Float4 now, const Float4* rest, int count,
                                                    NearestSearch::Found* found) {
  using F = Floats<kQuads>;
  using I = Ints<kQuads>;
  const auto each = [](glm::vec3 v) __attribute__((always_inline)) {
    return all<kQuads>(v.x, v.y, v.z);
  };
  const F last = each(corners.last);
  const F last_cell = each(corners.last_cell);
  const F spacing = each(corners.spacing_mm);
  const I strides =
      quads::all_ints<kQuads>(corners.strides.x, corners.strides.y, corners.strides.z);
  const I block_strides = quads::all_ints<kQuads>(corners.block_strides.x, corners.block_strides.y,
                                                  corners.block_strides.z);
  const glm::vec3 upper = glm::min(corners.last, glm::vec3(1.0f));
  F to_corner[8];
  for (unsigned k = 0; k < 8; ++k) {
    to_corner[k] = each(upper * glm::vec3(k & 1u, k >> 1 & 1u, k >> 2));
  }
  const I corner_bits = quads::all_ints<kQuads>(1, 2, 4);
  F near_number{}, far_number{};
  for (int lane = 0; lane < 4 * kQuads; ++lane) {
    near_number[lane] = static_cast<float>(lane % 4);
    far_number[lane] = static_cast<float>(4 + lane % 4);
  }
  F target = all<kQuads>(now[0], now[1], now[2]);
  for (int q = 0; q < kQuads; ++q) target[4 * q] += static_cast<float>(q);
  for (int x = 0; x < count; x += kQuads) {
    F at;
    __builtin_memcpy(&at, rest + x, sizeof at);
    const F below_last = at < last ? at : last;
    const F inside = below_last > 0.0f ? below_last : F{};
    const I base = __builtin_convertvector(inside < last_cell ? inside : last_cell, I);
    const F lower = __builtin_convertvector(base, F);
    const I cell = quads::sum_ints<kQuads>(base * strides);
    const I block = quads::sum_ints<kQuads>((base >> EdgeBlocks::kLog2Edge) * block_strides);
    const char* u[kQuads];
    const char* around[kQuads];
    for (int q = 0; q < kQuads; ++q) {
      u[q] = corners.u + static_cast<std::ptrdiff_t>(sizeof(Float4)) * cell[4 * q];
      around[q] = corners.blocks + block[4 * q];
    }
    const F from = lower - target;
    F squares[8];
    for (std::size_t k = 0; k < 8; ++k) {
      const F away = (quads::load(u, corners.steps[k], F{}) + (from + to_corner[k])) * spacing;
      squares[k] = away * away;
    }
    const F near = quads::sums<kQuads>(squares[0], squares[1], squares[2], squares[3]);
    const F far = quads::sums<kQuads>(squares[4], squares[5], squares[6], squares[7]);
    const F least = least_of_all<kQuads>(near, far);
    const F none = all<kQuads>(8.0f);
    const F number =
        least_of_all<kQuads>(near == least ? near_number : none, far == least ? far_number : none);
    const I corner = __builtin_convertvector(number, I) & corner_bits;
    const I nearest = base - (corner != 0);
    // What lies one element beyond the cell is to be looked at where it might be as near.
    const F before = lower - 1.0f > 0.0f ? lower - 1.0f : F{};
    const F behind = lower + 2.0f < last ? lower + 2.0f : last;
    const F to_before = inside - before;
    const F to_behind = behind - inside;
    const F gap = (to_before < to_behind ? to_before : to_behind) - kSlack_voxels;
    const F open = gap > 0.0f ? gap : F{};
    const F reach_squared = quads::load(around, 0, F{});
    const I beyond =
        quads::sum_ints<kQuads>((reach_squared * least >= open * open) | (inside != at));
    Int4 elements[kQuads];
    __builtin_memcpy(elements, &nearest, sizeof nearest);
    for (int q = 0; q < kQuads; ++q) {
      found[x + q] = {elements[q], least[4 * q], beyond[4 * q] != 0};
    }
    target += all<kQuads>(static_cast<float>(kQuads), 0.0f, 0.0f);
  }
}

MAILLE_ONE_OF_WIDTHS(void, among_corners, among_corners_of,
                     (const NearestSearch::Corners& corners, Float4 now, const Float4* rest,
                      int count, NearestSearch::Found* found),
                     (corners, now, rest, count, found))

}  // namespace

void NearestSearch::find(Float4 now, const Float4* rest, int count, std::uint32_t wanted,
                         Found* found) {
  const auto search = registers_ == Registers::widest ? among_corners : among_corners_16;
  search(corners_, now, rest, count, found);
  for (int x = 0; x < count; ++x) {
    if (found[x].maybe_further && (wanted >> x & 1u) != 0) {
      look_further(now + Float4{static_cast<float>(x), 0.0f, 0.0f, 0.0f}, rest[x], found[x]);
    }
  }
}

const NearestSearch::Block& NearestSearch::block_of(Float4 rest) {
  if (!edges_) return blocks_.front();
  const Float4 inside = least(greatest(rest, Float4{}), last_);
  const VoxelIndex element(static_cast<int>(inside[0]), static_cast<int>(inside[1]),
                           static_cast<int>(inside[2]));
  const VoxelIndex index = element >> EdgeBlocks::kLog2Edge;
  Block& block = blocks_[static_cast<std::size_t>(linear_index(index, edges_->size()))];
  if (block.hi[0] == 0.0f) {
    const EdgeBlocks::Surroundings around = edges_->around(index);
    const glm::vec3 spacing_mm(spacing_mm_[0], spacing_mm_[1], spacing_mm_[2]);
    const Float4 reach = reach_of(DisplacementTile::injection_of(around.edges), spacing_mm);
    block = {reach * reach, reach, float4(around.lo), float4(around.hi)};
  }
  return block;
}

void NearestSearch::look_further(Float4 now, Float4 rest, Found& found) {
  const Block& block = block_of(rest);
  const Float4 distance = splat(std::sqrt(found.squared_mm));
  Float4 reach = block.reach * distance + kSlack_voxels;
  if (!all_of((rest - reach > block.lo) & (rest + reach < block.hi))) {
    reach = reach_ * distance + kSlack_voxels;
  }
  const Float4 lowest = ceil(least(greatest(rest - reach, Float4{}), last_));
  const Float4 highest = floor(least(greatest(rest + reach, Float4{}), last_));
  const Int4 first = __builtin_convertvector(lowest, Int4);
  const Int4 end = __builtin_convertvector(highest, Int4);
  // Squares of distances are ordered as their bits are; below these, which element it is.
  std::uint64_t nearest = std::numeric_limits<std::uint64_t>::max();
  for (int z = first[2]; z <= end[2]; ++z) {
    for (int y = first[1]; y <= end[1]; ++y) {
      const Float4* const u = tile_.row(y, z);
      Float4 from =
          Float4{static_cast<float>(first[0]), static_cast<float>(y), static_cast<float>(z), 0.0f} -
          now;
      const auto row = static_cast<std::uint32_t>((z * tile_.height() + y) * tile_.width());
      for (int x = first[0]; x <= end[0]; ++x) {
        const Float4 away = (u[x] + from) * spacing_mm_;
        const Float4 squares = away * away;
        const float squared = (squares[0] + squares[2]) + squares[1];
        nearest = std::min(nearest, std::uint64_t{std::bit_cast<std::uint32_t>(squared)} << 32 |
                                        (row + static_cast<std::uint32_t>(x)));
        from += Float4{1.0f, 0.0f, 0.0f, 0.0f};
      }
    }
  }
  const VoxelIndex at =
      voxel_index(static_cast<std::int64_t>(nearest & 0xffffffffu), tile_.elements().size());
  found.element = Int4{at.x, at.y, at.z, 0};
  found.squared_mm = std::bit_cast<float>(static_cast<std::uint32_t>(nearest >> 32));
}

}  // namespace maille
