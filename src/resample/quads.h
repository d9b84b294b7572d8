// Vectors of x, y, z and a lane to spare, one or two of them in a register: what the machine has
// room for. Each is worked on as if it were alone, so both widths give the same bits.
//
// All of it must be inlined, lambdas too: functions for machines with wide registers and without
// hand them over in different places.
#pragma once

#include <cstdint>
#include <utility>

namespace maille::quads {

template <int kQuads>
struct Register;
template <>
struct Register<1> {
  using Floats = float __attribute__((vector_size(16)));
  using Ints = std::int32_t __attribute__((vector_size(16)));
};
template <>
struct Register<2> {
  using Floats = float __attribute__((vector_size(32)));
  using Ints = std::int32_t __attribute__((vector_size(32)));
};
template <int kQuads>
using Floats = typename Register<kQuads>::Floats;
template <int kQuads>
using Ints = typename Register<kQuads>::Ints;

namespace detail {
template <int kX, int kY, int kZ, int... kLane>
[[gnu::always_inline]] constexpr auto order(std::integer_sequence<int, kLane...>) {
  constexpr int kFrom[4] = {kX, kY, kZ, 3};
  return Ints<static_cast<int>(sizeof...(kLane)) / 4>{(kLane / 4 * 4 + kFrom[kLane % 4])...};
}
template <int... kLane>
[[gnu::always_inline]] constexpr auto repeated(float x, float y, float z,
                                               std::integer_sequence<int, kLane...>) {
  const float from[4] = {x, y, z, 0.0f};
  return Floats<static_cast<int>(sizeof...(kLane)) / 4>{from[kLane % 4]...};
}
// Two lanes of each from kFirst on, of one and the other in turn.
template <int kFirst, int... kLane>
[[gnu::always_inline]] constexpr auto in_turn(std::integer_sequence<int, kLane...>) {
  constexpr int kLanes = static_cast<int>(sizeof...(kLane));
  return Ints<kLanes / 4>{
      (kLane / 4 * 4 + kFirst + kLane % 4 / 2 + (kLane % 2 == 0 ? 0 : kLanes))...};
}
}  // namespace detail

template <int kQuads>
using Lanes = std::make_integer_sequence<int, 4 * kQuads>;

// The same vector in all quads.
template <int kQuads>
[[gnu::always_inline]] inline Floats<kQuads> all(float x, float y, float z) {
  return detail::repeated(x, y, z, Lanes<kQuads>());
}
template <int kQuads>
[[gnu::always_inline]] inline Ints<kQuads> all_ints(int x, int y, int z) {
  Ints<kQuads> v{};
  for (int q = 0; q < kQuads; ++q) {
    v[4 * q] = x;
    v[4 * q + 1] = y;
    v[4 * q + 2] = z;
  }
  return v;
}
template <int kQuads>
[[gnu::always_inline]] inline Floats<kQuads> all(float value) {
  return Floats<kQuads>{} + value;
}

// Components in another order within each.
template <int kX, int kY, int kZ, int kQuads>
[[gnu::always_inline]] inline Floats<kQuads> swizzle(Floats<kQuads> v) {
  return __builtin_shuffle(v, detail::order<kX, kY, kZ>(Lanes<kQuads>()));
}
template <int kX, int kY, int kZ, int kQuads>
[[gnu::always_inline]] inline Ints<kQuads> swizzle_ints(Ints<kQuads> v) {
  return __builtin_shuffle(v, detail::order<kX, kY, kZ>(Lanes<kQuads>()));
}

template <int kFirst, int kQuads>
[[gnu::always_inline]] inline Floats<kQuads> interleaved(Floats<kQuads> a, Floats<kQuads> b) {
  return __builtin_shuffle(a, b, detail::in_turn<kFirst>(Lanes<kQuads>()));
}

template <int kQuads>
[[gnu::always_inline]] inline Floats<kQuads> cross(Floats<kQuads> a, Floats<kQuads> b) {
  const Floats<kQuads> c = a * swizzle<1, 2, 0, kQuads>(b) - swizzle<1, 2, 0, kQuads>(a) * b;
  return swizzle<1, 2, 0, kQuads>(c);
}
// The sums of the lanes of four vectors, as the lanes of one.
template <int kQuads>
[[gnu::always_inline]] inline Floats<kQuads> sums(Floats<kQuads> a, Floats<kQuads> b,
                                                  Floats<kQuads> c, Floats<kQuads> d) {
  using F = Floats<kQuads>;
  const F ac = interleaved<0, kQuads>(a, c) + interleaved<2, kQuads>(a, c);
  const F bd = interleaved<0, kQuads>(b, d) + interleaved<2, kQuads>(b, d);
  return interleaved<0, kQuads>(ac, bd) + interleaved<2, kQuads>(ac, bd);
}
template <int kQuads>
[[gnu::always_inline]] inline Ints<kQuads> sum_ints(Ints<kQuads> v) {
  return v + swizzle_ints<1, 2, 0, kQuads>(v) + swizzle_ints<2, 0, 1, kQuads>(v);
}
// The largest size of a component, in all three lanes.
template <int kQuads>
[[gnu::always_inline]] inline Floats<kQuads> largest(Floats<kQuads> v) {
  const Floats<kQuads> size = v > -v ? v : -v;
  const Floats<kQuads> next = swizzle<1, 2, 0, kQuads>(size);
  const Floats<kQuads> last = swizzle<2, 0, 1, kQuads>(size);
  const Floats<kQuads> of_two = size > next ? size : next;
  return of_two > last ? of_two : last;
}

// Those so many bytes on from some places, side by side.
[[gnu::always_inline]] inline Floats<1> load_quad(const char* at, std::ptrdiff_t bytes) {
  return *reinterpret_cast<const Floats<1>*>(at + bytes);
}
[[gnu::always_inline]] inline Floats<1> load(const char* const* at, std::ptrdiff_t bytes,
                                             Floats<1>) {
  return load_quad(at[0], bytes);
}
[[gnu::always_inline]] inline Floats<2> load(const char* const* at, std::ptrdiff_t bytes,
                                             Floats<2>) {
  return __builtin_shufflevector(load_quad(at[0], bytes), load_quad(at[1], bytes), 0, 1, 2, 3, 4, 5,
                                 6, 7);
}
}  // namespace maille::quads
