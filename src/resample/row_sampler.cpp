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

// The components of t, falling, and where the path from the lowest corner to the opposite one leads
// along them; of equal ones the first axis comes first.
MAILLE_FOR_SEVERAL_WIDTHS
void choose_path(const float (&t)[3][kBrickEdge], const std::int64_t (&step)[3], int count,
                 float (&along)[3][kBrickEdge], std::int64_t* second, std::int64_t* third) {
  const std::int64_t step_x = step[0];
  const std::int64_t step_y = step[1];
  const std::int64_t step_z = step[2];
  const std::int64_t opposite = step_x + step_y + step_z;
  for (int x = 0; x < count; ++x) {
    const float a = t[0][x];
    const float b = t[1][x];
    const float c = t[2][x];
    const float larger = a > b ? a : b;
    const float smaller = a > b ? b : a;
    const float below_larger = c < larger ? c : larger;
    along[0][x] = c > larger ? c : larger;
    along[1][x] = below_larger > smaller ? below_larger : smaller;
    along[2][x] = c < smaller ? c : smaller;
    second[x] = (a >= b) & (a >= c) ? step_x : b >= c ? step_y : step_z;
    third[x] = opposite - ((c <= a) & (c <= b) ? step_z : b <= a ? step_y : step_x);
  }
}

// One after the other from the end, so that equal values and points on a corner mix to themselves.
MAILLE_FOR_SEVERAL_WIDTHS
void mix_path(const float (&corner)[8][kBrickEdge], const float (&along)[3][kBrickEdge], int count,
              float* value) {
  for (int x = 0; x < count; ++x) {
    const float first = along[0][x];
    const float second = along[1][x];
    const float to_third = first > 0.0f ? second / first : 0.0f;
    const float to_last = second > 0.0f ? along[2][x] / second : 0.0f;
    const float beyond_third = between(corner[2][x], corner[3][x], to_last);
    value[x] = between(corner[0][x], between(corner[1][x], beyond_third, to_third), first);
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
  std::int32_t all = 1;
  for (int x = 0; x < count; ++x) all &= among_[x];
  all_among_ = all != 0;
  const std::int64_t origin = linear_index(first_, size_);
  const std::int64_t plane = std::int64_t{size_.x} * size_.y;
  for (int x = 0; x < count; ++x) {
    offset_[x] = origin + base[2][x] * plane + base[1][x] * std::int64_t{size_.x} + base[0][x];
  }
}

void RowSampler::choose_tetrahedra(int count) {
  choose_path(t_, {step_x_, step_y_, step_z_}, count, along_, second_, third_);
}

void RowSampler::mix_along_path(int count) { mix_path(corner_, along_, count, value_); }

void RowSampler::mix(int count) { mix_corners(corner_, t_, count, value_); }

}  // namespace maille
