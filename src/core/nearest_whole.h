// The nearest whole number of a float, ties to the even one, in two operations that a loop of
// vectors has on every machine. Below 2^22 in size.
#pragma once

namespace maille {

[[gnu::always_inline]] inline float nearest_whole(float value) {
  constexpr float kOneAndAHalfTimes2To23 = 12582912.0f;
  return (value + kOneAndAHalfTimes2To23) - kOneAndAHalfTimes2To23;
}

}  // namespace maille
