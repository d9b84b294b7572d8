#include "resample/row_sampler.h"

#include <algorithm>

#include "core/nearest_whole.h"
#include "resample/claims.h"

namespace maille {
namespace {

struct Axis {
  float lowest;  // that counts
  float highest;
  float first;  // element
  float last;
  float last_cell;  // its lower element
};

MAILLE_FOR_SEVERAL_WIDTHS
void locate_along(const Axis& axis, const float* at, int count, float* t, std::int32_t* base,
                  std::int32_t* among) {
  const auto [lowest, highest, first, last, last_cell] = axis;
  for (int x = 0; x < count; ++x) {
    among[x] &= (at[x] >= lowest) & (at[x] <= highest);
    float inside = at[x] < last ? at[x] : last;
    inside = inside > first ? inside : first;
    float floor = nearest_whole(inside);
    floor = floor > inside ? floor - 1.0f : floor;
    floor = floor < last_cell ? floor : last_cell;
    base[x] = static_cast<std::int32_t>(floor);
    t[x] = inside - floor;
  }
}

MAILLE_FOR_SEVERAL_WIDTHS
void snap(float* at_x, float* at_y, float* at_z, int count) {
  for (int x = 0; x < count; ++x) {
    const float whole_x = nearest_whole(at_x[x]);
    const float whole_y = nearest_whole(at_y[x]);
    const float whole_z = nearest_whole(at_z[x]);
    const bool near = (std::abs(at_x[x] - whole_x) < kOnElement_cells) &
                      (std::abs(at_y[x] - whole_y) < kOnElement_cells) &
                      (std::abs(at_z[x] - whole_z) < kOnElement_cells);
    at_x[x] = near ? whole_x : at_x[x];
    at_y[x] = near ? whole_y : at_y[x];
    at_z[x] = near ? whole_z : at_z[x];
  }
}

[[gnu::always_inline]] inline float between(float a, float b, float s) {
  const float mixed = a + s * (b - a);
  return (s == 0.0f) | (a == b) ? a : mixed;
}

MAILLE_FOR_SEVERAL_WIDTHS
void mix_corners(const float (&corner)[8][kBrickEdge], const float (&t)[3][kBrickEdge], int count,
                 float* value) {
  for (int x = 0; x < count; ++x) {
    const float near = between(between(corner[0][x], corner[1][x], t[0][x]),
                               between(corner[2][x], corner[3][x], t[0][x]), t[1][x]);
    const float far = between(between(corner[4][x], corner[5][x], t[0][x]),
                              between(corner[6][x], corner[7][x], t[0][x]), t[1][x]);
    value[x] = between(near, far, t[2][x]);
  }
}

}  // namespace

RowSampler::RowSampler(Size3 size, const VoxelBox& elements)
    : first_(elements.lo),
      size_(size),
      step_x_(size.x > 1 ? 1 : 0),
      step_y_(size.y > 1 ? size.x : 0),
      step_z_(size.z > 1 ? std::int64_t{size.x} * size.y : 0) {
  for (int c = 0; c < 3; ++c) {
    const float below = elements.lo[c] == 0 ? 0.5f : 0.0f;
    const float above = elements.hi[c] == size[c] ? 0.5f : 0.0f;
    lowest_[c] = -below - kInside_cells;
    highest_[c] = static_cast<float>(elements.size()[c] - 1) + above + kInside_cells;
  }
}

void RowSampler::locate(const Float4* rest, int count) {
  std::int32_t base[3][kBrickEdge];
  for (int x = 0; x < count; ++x) {
    at_[0][x] = rest[x][0];
    at_[1][x] = rest[x][1];
    at_[2][x] = rest[x][2];
  }
  snap(at_[0], at_[1], at_[2], count);
  std::fill_n(among_, count, 1);
  for (int c = 0; c < 3; ++c) {
    const auto first = static_cast<float>(-first_[c]);
    const auto last = static_cast<float>(size_[c] - 1 - first_[c]);
    locate_along({lowest_[c], highest_[c], first, last, std::max(last - 1.0f, first)}, at_[c],
                 count, t_[c], base[c], among_);
  }
  const std::int64_t origin = linear_index(first_, size_);
  const std::int64_t plane = std::int64_t{size_.x} * size_.y;
  for (int x = 0; x < count; ++x) {
    offset_[x] = origin + base[2][x] * plane + base[1][x] * std::int64_t{size_.x} + base[0][x];
  }
}

void RowSampler::mix(int count) { mix_corners(corner_, t_, count, value_); }

}  // namespace maille
