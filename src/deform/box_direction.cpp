#include "deform/box_direction.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/nearest_whole.h"
#include "core/several_widths.h"

namespace maille {
namespace {

// Of what is furthest: it takes 2^13 to 2^14 units, which are powers of two, so that what is kept
// is kept as it is again.
constexpr int kBits = 14;

MAILLE_FOR_SEVERAL_WIDTHS
float largest(const float* values, int count) {
  constexpr int kLanes = 16;
  float lanes[kLanes] = {};
  const int whole = count / kLanes * kLanes;
  for (int x = 0; x < whole; x += kLanes) {
    for (int l = 0; l < kLanes; ++l) {
      const float size = std::abs(values[x + l]);
      lanes[l] = size > lanes[l] ? size : lanes[l];
    }
  }
  for (int x = whole; x < count; ++x) lanes[0] = std::max(lanes[0], std::abs(values[x]));
  return *std::max_element(lanes, lanes + kLanes);
}

MAILLE_FOR_SEVERAL_WIDTHS
void narrow(const float* from, float units_per_mm, int count, std::int16_t* to) {
  for (int x = 0; x < count; ++x) {
    to[x] = static_cast<std::int16_t>(static_cast<int>(nearest_whole(from[x] * units_per_mm)));
  }
}

MAILLE_FOR_SEVERAL_WIDTHS
void widen(const std::int16_t* from, float unit_mm, int count, float* to) {
  for (int x = 0; x < count; ++x) to[x] = unit_mm * static_cast<float>(from[x]);
}

}  // namespace

BoxDirection::BoxDirection(Size3 extent, WorkerPool& pool)
    : columns_(extent.x),
      room_(extent.y + 2),
      units_{BoxArray<std::int16_t>(extent, pool), BoxArray<std::int16_t>(extent, pool),
             BoxArray<std::int16_t>(extent, pool)},
      unit_mm_(static_cast<std::size_t>(std::int64_t{extent.y} * extent.z + 2 * room_), 0.0f) {}

void BoxDirection::set_row(std::int64_t row, const float* x_mm, const float* y_mm,
                           const float* z_mm) {
  const std::array<const float*, 3> parts = {x_mm, y_mm, z_mm};
  float most_mm = 0.0f;
  for (const float* const part : parts) most_mm = std::max(most_mm, largest(part, columns_));
  int exponent = 0;
  static_cast<void>(std::frexp(most_mm, &exponent));
  const float unit_mm = std::ldexp(1.0f, exponent - kBits);
  // A unit too small to divide by: nothing in the row moves as far as floats can tell.
  const bool moves = most_mm > 0.0f && unit_mm >= std::numeric_limits<float>::min();
  unit_mm_[static_cast<std::size_t>(row + room_)] = moves ? unit_mm : 0.0f;
  const float units_per_mm = moves ? 1.0f / unit_mm : 0.0f;
  for (std::size_t c = 0; c < 3; ++c) {
    narrow(parts[c], units_per_mm, columns_, &units_[c][row * columns_]);
  }
}

void BoxDirection::get_row(std::int64_t row, float* x_mm, float* y_mm, float* z_mm) const {
  const std::array<float*, 3> parts = {x_mm, y_mm, z_mm};
  for (std::size_t c = 0; c < 3; ++c) {
    widen(&units_[c][row * columns_], unit_mm(row), columns_, parts[c]);
  }
}

std::int64_t BoxDirection::bytes() const {
  return units_[0].bytes() + units_[1].bytes() + units_[2].bytes() +
         static_cast<std::int64_t>(unit_mm_.size() * sizeof(float));
}

}  // namespace maille
