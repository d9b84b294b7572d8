#include "deform/spring_rows.h"

#include <cmath>

#include "core/several_widths.h"

namespace maille {
namespace {

constexpr int kLanes = 8;

// What a loop over a run reads, by value: through references the compiler must fear that what it
// writes overwrites what it reads.
struct Inputs {
  const float* u_x;
  const float* u_y;
  const float* u_z;
  const float* compliance;  // null: one for all
  const float* blend;       // null: one for all
  const std::uint32_t* missing;
  const float* kept_x;  // null: 0 at all ends of its springs
  const float* kept_y;
  const float* kept_z;
  float one_compliance;
  float one_blend;
  int count;
};

// A direction from the state.
struct Way {
  const BoxDirection& direction;
  std::int64_t first;  // element
  std::int64_t row;
  std::int64_t rows_of_plane;
};

// In a loop of its own: halves beside floats would be taken 32 at a time, and many rows end first.
[[gnu::always_inline]] inline void widen(const Way& way, std::size_t component, std::int64_t step,
                                         std::int64_t rows, int count, float* to) {
  const std::int16_t* const from = way.direction.units(component, way.first + step);
  const float unit_mm = way.direction.unit_mm(way.row + rows);
  for (int x = 0; x < count; ++x) to[x] = unit_mm * static_cast<float>(from[x]);
}

Inputs inputs_of(const SpringBox& box, const SpringRun& run) {
  const bool plain = run.kind == RowKind::plain;
  Inputs in{};
  in.u_x = &box.u_mm()[0][run.first];
  in.u_y = &box.u_mm()[1][run.first];
  in.u_z = &box.u_mm()[2][run.first];
  if (!plain && box.compliances()) in.compliance = box.compliances() + run.first;
  if (!plain && box.blends()) in.blend = box.blends() + run.first;
  in.one_compliance = box.compliance(run.first);
  in.one_blend = box.blend(run.first);
  in.missing = run.missing;
  if (run.keeps) {
    in.kept_x = &box.kept_mm()[0][run.first];
    in.kept_y = &box.kept_mm()[1][run.first];
    in.kept_z = &box.kept_mm()[2][run.first];
  }
  in.count = run.count;
  return in;
}

// Stiffness of a spring from element x on by `step`, without a branch that a vector cannot take.
template <bool kMixed, bool kCut>
[[gnu::always_inline]] inline float stiffness_of(const Inputs& in, const float* other, int x,
                                                 float one, std::uint32_t bit) {
  float k = one;
  if constexpr (kMixed) k = 2.0f / (in.compliance[x] + other[x]);
  if constexpr (kCut) k = in.missing[x] & bit ? 0.0f : k;
  return k;
}

template <bool kMixed, bool kBlends, bool kCut, bool kKeeps>
[[gnu::always_inline]] inline void add_up_forces(const Inputs& inputs, const Springs& springs,
                                                 const std::int64_t* steps, RunVectors& forces) {
  const Inputs in = inputs;
  const float* const u_x = in.u_x;
  const float* const u_y = in.u_y;
  const float* const u_z = in.u_z;
  const int count = in.count;
  const float one = 1.0f / in.one_compliance;
  float force_x[kLongestRun] = {};
  float force_y[kLongestRun] = {};
  float force_z[kLongestRun] = {};
  for (int s = 0; s < kSprings; ++s) {
    const Spring& spring = springs[static_cast<std::size_t>(s)];
    const std::int64_t j = steps[s];
    // The springs' other ends; pointers of their own, or the compiler does not see a plain stride.
    const float* const other_x = u_x + j;
    const float* const other_y = u_y + j;
    const float* const other_z = u_z + j;
    const float* const other_compliance = kMixed ? in.compliance + j : nullptr;
    const float* const other_blend = kBlends ? in.blend + j : nullptr;
    const float* const kept_x = in.kept_x;
    const float* const kept_y = in.kept_y;
    const float* const kept_z = in.kept_z;
    const float* const other_kept_x = kKeeps ? kept_x + j : nullptr;
    const float* const other_kept_y = kKeeps ? kept_y + j : nullptr;
    const float* const other_kept_z = kKeeps ? kept_z + j : nullptr;
    const float rest_x = spring.rest_mm.x;
    const float rest_y = spring.rest_mm.y;
    const float rest_z = spring.rest_mm.z;
    const float length_mm = spring.length_mm;
    const std::uint32_t bit = std::uint32_t{1} << s;
    for (int x = 0; x < count; ++x) {
      float du_x = u_x[x] - other_x[x];
      float du_y = u_y[x] - other_y[x];
      float du_z = u_z[x] - other_z[x];
      const float p_x = rest_x + du_x;
      const float p_y = rest_y + du_y;
      const float p_z = rest_z + du_z;
      float rest_length = length_mm;
      if constexpr (kKeeps) {
        const float g_x = kept_x[x] - other_kept_x[x];
        const float g_y = kept_y[x] - other_kept_y[x];
        const float g_z = kept_z[x] - other_kept_z[x];
        const float r_x = rest_x + g_x;
        const float r_y = rest_y + g_y;
        const float r_z = rest_z + g_z;
        rest_length = std::sqrt(r_x * r_x + r_y * r_y + r_z * r_z);
        du_x -= g_x;
        du_y -= g_y;
        du_z -= g_z;
      }
      const float k = stiffness_of<kMixed, kCut>(in, other_compliance, x, one, bit);
      float b = in.one_blend;
      if constexpr (kBlends) b = 0.5f * (in.blend[x] + other_blend[x]);
      // A pair at zero distance has no direction: p is 0, and so is this part of its force.
      const float length = std::sqrt(p_x * p_x + p_y * p_y + p_z * p_z + 1e-30f);
      const float along = (1.0f - b) * k * (1.0f - rest_length / length);
      const float straight = b * k;
      force_x[x] -= along * p_x + straight * du_x;
      force_y[x] -= along * p_y + straight * du_y;
      force_z[x] -= along * p_z + straight * du_z;
    }
  }
  for (int x = 0; x < count; ++x) {
    forces.x[x] = force_x[x];
    forces.y[x] = force_y[x];
    forces.z[x] = force_z[x];
  }
}

template <bool kMixed, bool kBlends, bool kCut, bool kSomeHeld, bool kKeeps>
[[gnu::always_inline]] inline SpringSums add_up_sums(const Inputs& inputs, const Springs& springs,
                                                     const std::int64_t* steps, const Way& way,
                                                     const std::uint8_t* free) {
  const Inputs in = inputs;
  const float* const u_x = in.u_x;
  const float* const u_y = in.u_y;
  const float* const u_z = in.u_z;
  float d_x[kLongestRun];
  float d_y[kLongestRun];
  float d_z[kLongestRun];
  widen(way, 0, 0, 0, in.count, d_x);
  widen(way, 1, 0, 0, in.count, d_y);
  widen(way, 2, 0, 0, in.count, d_z);
  const float one = 1.0f / in.one_compliance;
  float energy[kLongestRun + kLanes] = {};
  float curvature[kLongestRun + kLanes] = {};
  for (int s = 0; s < kSprings; s += 2) {
    const Spring& spring = springs[static_cast<std::size_t>(s)];
    const std::int64_t j = steps[s];
    // The springs' other ends; pointers of their own, or the compiler does not see a plain stride.
    const float* const other_x = u_x + j;
    const float* const other_y = u_y + j;
    const float* const other_z = u_z + j;
    const float* const other_compliance = kMixed ? in.compliance + j : nullptr;
    const float* const other_blend = kBlends ? in.blend + j : nullptr;
    const float* const kept_x = in.kept_x;
    const float* const kept_y = in.kept_y;
    const float* const kept_z = in.kept_z;
    const float* const other_kept_x = kKeeps ? kept_x + j : nullptr;
    const float* const other_kept_y = kKeeps ? kept_y + j : nullptr;
    const float* const other_kept_z = kKeeps ? kept_z + j : nullptr;
    const float rest_x = spring.rest_mm.x;
    const float rest_y = spring.rest_mm.y;
    const float rest_z = spring.rest_mm.z;
    const float length_mm = spring.length_mm;
    float other_d_x[kLongestRun];
    float other_d_y[kLongestRun];
    float other_d_z[kLongestRun];
    const std::int64_t rows = spring.offset.z * way.rows_of_plane + spring.offset.y;
    widen(way, 0, j, rows, in.count, other_d_x);
    widen(way, 1, j, rows, in.count, other_d_y);
    widen(way, 2, j, rows, in.count, other_d_z);
    [[maybe_unused]] float any_free[kLongestRun];
    if constexpr (kSomeHeld) {
      // A loop of its own: bytes beside floats would be taken 64 at a time, and most rows end
      // first.
      const std::uint8_t* const other_free = free + j;
      for (int x = 0; x < in.count; ++x) any_free[x] = static_cast<float>(free[x] | other_free[x]);
    }
    const std::uint32_t bit = std::uint32_t{1} << s;
    for (int x = 0; x < in.count; ++x) {
      float du_x = u_x[x] - other_x[x];
      float du_y = u_y[x] - other_y[x];
      float du_z = u_z[x] - other_z[x];
      const float p_x = rest_x + du_x;
      const float p_y = rest_y + du_y;
      const float p_z = rest_z + du_z;
      float rest_length = length_mm;
      if constexpr (kKeeps) {
        const float g_x = kept_x[x] - other_kept_x[x];
        const float g_y = kept_y[x] - other_kept_y[x];
        const float g_z = kept_z[x] - other_kept_z[x];
        const float r_x = rest_x + g_x;
        const float r_y = rest_y + g_y;
        const float r_z = rest_z + g_z;
        rest_length = std::sqrt(r_x * r_x + r_y * r_y + r_z * r_z);
        du_x -= g_x;
        du_y -= g_y;
        du_z -= g_z;
      }
      const float q_x = d_x[x] - other_d_x[x];
      const float q_y = d_y[x] - other_d_y[x];
      const float q_z = d_z[x] - other_d_z[x];
      float k = stiffness_of<kMixed, kCut>(in, other_compliance, x, one, bit);
      if constexpr (kSomeHeld) k *= any_free[x];
      float b = in.one_blend;
      if constexpr (kBlends) b = 0.5f * (in.blend[x] + other_blend[x]);
      const float one_over_length = 1.0f / std::sqrt(p_x * p_x + p_y * p_y + p_z * p_z + 1e-30f);
      const float share = rest_length * one_over_length;
      const float q2 = q_x * q_x + q_y * q_y + q_z * q_z;
      const float along = (p_x * q_x + p_y * q_y + p_z * q_z) * one_over_length;
      const float stretch = (p_x * p_x + p_y * p_y + p_z * p_z) * one_over_length - rest_length;
      energy[x] +=
          k * ((1.0f - b) * stretch * stretch + b * (du_x * du_x + du_y * du_y + du_z * du_z));
      curvature[x] += k * ((1.0f - b) * (share * along * along + (1.0f - share) * q2) + b * q2);
    }
  }
  double lanes[2][kLanes] = {};
  for (int x = 0; x < in.count; x += kLanes) {
    for (int l = 0; l < kLanes; ++l) {
      lanes[0][l] += static_cast<double>(energy[x + l]);
      lanes[1][l] += static_cast<double>(curvature[x + l]);
    }
  }
  SpringSums sums;
  for (int l = 0; l < kLanes; ++l) {
    sums.energy += 0.5 * lanes[0][l];
    sums.curvature += lanes[1][l];
  }
  return sums;
}

// The springs of one stiffness: the four rows beside an element's own count with all three columns,
// its own with the two outer ones, the four across with the middle one.
[[gnu::always_inline]] inline void plain_laplacian(const RowsAround& rows, float k, int count,
                                                   float* out) {
  const float* const own = rows.at[4];
  const float* const a = rows.at[1];
  const float* const b = rows.at[3];
  const float* const c = rows.at[5];
  const float* const d = rows.at[7];
  const float* const e = rows.at[0];
  const float* const f = rows.at[2];
  const float* const g = rows.at[6];
  const float* const h = rows.at[8];
  for (int x = 0; x < count; ++x) {
    const float middle = (a[x] + b[x]) + (c[x] + d[x]);
    const float left = (a[x - 1] + b[x - 1]) + (c[x - 1] + d[x - 1]) + own[x - 1];
    const float right = (a[x + 1] + b[x + 1]) + (c[x + 1] + d[x + 1]) + own[x + 1];
    const float across = (e[x] + f[x]) + (g[x] + h[x]);
    out[x] = k * (static_cast<float>(kSprings) * own[x] - ((left + right) + (middle + across)));
  }
}

template <bool kMixed, bool kCut>
[[gnu::always_inline]] inline void mixed_laplacian(const Inputs& inputs, const Springs& springs,
                                                   const std::int64_t* steps,
                                                   const std::array<RowsAround, 3>& w,
                                                   RunVectors& out) {
  const Inputs in = inputs;
  const float one = 1.0f / in.one_compliance;
  float sum_x[kLongestRun] = {};
  float sum_y[kLongestRun] = {};
  float sum_z[kLongestRun] = {};
  for (int s = 0; s < kSprings; ++s) {
    const glm::ivec3 o = springs[static_cast<std::size_t>(s)].offset;
    const auto row = static_cast<std::size_t>((o.z + 1) * 3 + o.y + 1);
    const float* const own_x = w[0].at[4];
    const float* const own_y = w[1].at[4];
    const float* const own_z = w[2].at[4];
    const float* const other_x = w[0].at[row] + o.x;
    const float* const other_y = w[1].at[row] + o.x;
    const float* const other_z = w[2].at[row] + o.x;
    const float* const other_compliance = kMixed ? in.compliance + steps[s] : nullptr;
    const std::uint32_t bit = std::uint32_t{1} << s;
    for (int x = 0; x < in.count; ++x) {
      const float k = stiffness_of<kMixed, kCut>(in, other_compliance, x, one, bit);
      sum_x[x] += k * (own_x[x] - other_x[x]);
      sum_y[x] += k * (own_y[x] - other_y[x]);
      sum_z[x] += k * (own_z[x] - other_z[x]);
    }
  }
  for (int x = 0; x < in.count; ++x) {
    out.x[x] = sum_x[x];
    out.y[x] = sum_y[x];
    out.z[x] = sum_z[x];
  }
}

template <bool kMixed, bool kCut>
[[gnu::always_inline]] inline void stiffnesses_of(const Inputs& inputs, std::int64_t step,
                                                  int spring, float* k) {
  const Inputs in = inputs;
  const float one = 1.0f / in.one_compliance;
  const float* const other_compliance = kMixed ? in.compliance + step : nullptr;
  const std::uint32_t bit = std::uint32_t{1} << spring;
  for (int x = 0; x < in.count; ++x)
    k[x] = stiffness_of<kMixed, kCut>(in, other_compliance, x, one, bit);
}

MAILLE_FOR_SEVERAL_WIDTHS
void forces_plain(const Inputs& in, const Springs& springs, const std::int64_t* steps,
                  RunVectors& out) {
  add_up_forces<false, false, false, false>(in, springs, steps, out);
}
MAILLE_FOR_SEVERAL_WIDTHS
void forces_mixed(const Inputs& in, const Springs& springs, const std::int64_t* steps,
                  RunVectors& out) {
  add_up_forces<true, false, false, false>(in, springs, steps, out);
}
MAILLE_FOR_SEVERAL_WIDTHS
void forces_blended(const Inputs& in, const Springs& springs, const std::int64_t* steps,
                    RunVectors& out) {
  add_up_forces<true, true, false, false>(in, springs, steps, out);
}
MAILLE_FOR_SEVERAL_WIDTHS
void forces_cut(const Inputs& in, const Springs& springs, const std::int64_t* steps,
                RunVectors& out) {
  if (!in.compliance) return add_up_forces<false, false, true, false>(in, springs, steps, out);
  if (!in.blend) return add_up_forces<true, false, true, false>(in, springs, steps, out);
  add_up_forces<true, true, true, false>(in, springs, steps, out);
}

// Where material has yielded; few rows, so that one loop for all kinds would do, were its branches
// not in the way of vectors.
MAILLE_FOR_SEVERAL_WIDTHS
void forces_kept(const Inputs& in, const Springs& springs, const std::int64_t* steps,
                 RunVectors& out) {
  if (in.missing) {
    if (!in.compliance) return add_up_forces<false, false, true, true>(in, springs, steps, out);
    if (!in.blend) return add_up_forces<true, false, true, true>(in, springs, steps, out);
    return add_up_forces<true, true, true, true>(in, springs, steps, out);
  }
  if (!in.compliance) return add_up_forces<false, false, false, true>(in, springs, steps, out);
  if (!in.blend) return add_up_forces<true, false, false, true>(in, springs, steps, out);
  add_up_forces<true, true, false, true>(in, springs, steps, out);
}

MAILLE_FOR_SEVERAL_WIDTHS
SpringSums sums_plain(const Inputs& in, const Springs& springs, const std::int64_t* steps,
                      const Way& way, const std::uint8_t* free) {
  if (!free) return add_up_sums<false, false, false, false, false>(in, springs, steps, way, free);
  return add_up_sums<false, false, false, true, false>(in, springs, steps, way, free);
}
MAILLE_FOR_SEVERAL_WIDTHS
SpringSums sums_mixed(const Inputs& in, const Springs& springs, const std::int64_t* steps,
                      const Way& way, const std::uint8_t* free) {
  return add_up_sums<true, false, false, true, false>(in, springs, steps, way, free);
}
MAILLE_FOR_SEVERAL_WIDTHS
SpringSums sums_blended(const Inputs& in, const Springs& springs, const std::int64_t* steps,
                        const Way& way, const std::uint8_t* free) {
  return add_up_sums<true, true, false, true, false>(in, springs, steps, way, free);
}
MAILLE_FOR_SEVERAL_WIDTHS
SpringSums sums_cut(const Inputs& in, const Springs& springs, const std::int64_t* steps,
                    const Way& way, const std::uint8_t* free) {
  if (!in.compliance)
    return add_up_sums<false, false, true, true, false>(in, springs, steps, way, free);
  if (!in.blend) return add_up_sums<true, false, true, true, false>(in, springs, steps, way, free);
  return add_up_sums<true, true, true, true, false>(in, springs, steps, way, free);
}

MAILLE_FOR_SEVERAL_WIDTHS
SpringSums sums_kept(const Inputs& in, const Springs& springs, const std::int64_t* steps,
                     const Way& way, const std::uint8_t* free) {
  if (in.missing) {
    if (!in.compliance)
      return add_up_sums<false, false, true, true, true>(in, springs, steps, way, free);
    if (!in.blend) return add_up_sums<true, false, true, true, true>(in, springs, steps, way, free);
    return add_up_sums<true, true, true, true, true>(in, springs, steps, way, free);
  }
  if (!in.compliance)
    return add_up_sums<false, false, false, true, true>(in, springs, steps, way, free);
  if (!in.blend) return add_up_sums<true, false, false, true, true>(in, springs, steps, way, free);
  return add_up_sums<true, true, false, true, true>(in, springs, steps, way, free);
}

MAILLE_FOR_SEVERAL_WIDTHS
void laplacian_plain(const std::array<RowsAround, 3>& w, float k, int count, RunVectors& out) {
  plain_laplacian(w[0], k, count, out.x);
  plain_laplacian(w[1], k, count, out.y);
  plain_laplacian(w[2], k, count, out.z);
}
MAILLE_FOR_SEVERAL_WIDTHS
void laplacian_mixed(const Inputs& in, const Springs& springs, const std::int64_t* steps,
                     const std::array<RowsAround, 3>& w, RunVectors& out) {
  mixed_laplacian<true, false>(in, springs, steps, w, out);
}
MAILLE_FOR_SEVERAL_WIDTHS
void laplacian_cut(const Inputs& in, const Springs& springs, const std::int64_t* steps,
                   const std::array<RowsAround, 3>& w, RunVectors& out) {
  if (!in.compliance) return mixed_laplacian<false, true>(in, springs, steps, w, out);
  mixed_laplacian<true, true>(in, springs, steps, w, out);
}
MAILLE_FOR_SEVERAL_WIDTHS
void stiffnesses_mixed(const Inputs& in, std::int64_t step, int spring, float* k) {
  if (!in.missing) return stiffnesses_of<true, false>(in, step, spring, k);
  if (!in.compliance) return stiffnesses_of<false, true>(in, step, spring, k);
  stiffnesses_of<true, true>(in, step, spring, k);
}

}  // namespace

void spring_forces(const SpringBox& box, const SpringRun& run, RunVectors& forces) {
  const Inputs in = inputs_of(box, run);
  if (in.kept_x) return forces_kept(in, box.springs(), box.steps(), forces);
  if (in.missing) return forces_cut(in, box.springs(), box.steps(), forces);
  if (!in.compliance) return forces_plain(in, box.springs(), box.steps(), forces);
  if (!in.blend) return forces_mixed(in, box.springs(), box.steps(), forces);
  forces_blended(in, box.springs(), box.steps(), forces);
}

SpringSums spring_sums(const SpringBox& box, const SpringRun& run, const BoxDirection& direction) {
  const Inputs in = inputs_of(box, run);
  const Way d{direction, run.first, run.first / box.extent().x, box.extent().y};
  if (in.kept_x) {
    return sums_kept(in, box.springs(), box.steps(), d, box.free_flags() + run.first);
  }
  const bool no_held = run.with_free_around && run.kind == RowKind::plain;
  const std::uint8_t* const free = no_held ? nullptr : box.free_flags() + run.first;
  if (in.missing) return sums_cut(in, box.springs(), box.steps(), d, free);
  if (!in.compliance) return sums_plain(in, box.springs(), box.steps(), d, free);
  if (!in.blend) return sums_mixed(in, box.springs(), box.steps(), d, free);
  return sums_blended(in, box.springs(), box.steps(), d, free);
}

double spring_bound(const SpringBox& box, const SpringRun& run, const BoxDirection& direction) {
  double sum = 0.0;
  for (int s = 0; s < kSprings; s += 2) {
    float k[kLongestRun];
    stiffnesses(box, run, s, k);
    const std::int64_t step = box.step(s);
    for (int x = 0; x < run.count; ++x) {
      const std::int64_t i = run.first + x;
      for (std::size_t c = 0; c < 3; ++c) {
        const double along = double{direction.at(c, i)} - double{direction.at(c, i + step)};
        sum += double{k[x]} * along * along;
      }
    }
  }
  return sum;
}

MAILLE_FOR_SEVERAL_WIDTHS
float largest_square(const float* x, const float* y, const float* z, glm::vec3 scale, int count) {
  const float scale_x = scale.x;
  const float scale_y = scale.y;
  const float scale_z = scale.z;
  constexpr int kWide = 16;
  float lanes[kWide] = {};
  const int whole = count / kWide * kWide;
  for (int i = 0; i < whole; i += kWide) {
    for (int l = 0; l < kWide; ++l) {
      const float a = scale_x * x[i + l];
      const float b = scale_y * y[i + l];
      const float c = scale_z * z[i + l];
      const float square = a * a + b * b + c * c;
      lanes[l] = square > lanes[l] ? square : lanes[l];
    }
  }
  float largest = 0.0f;
  for (const float lane : lanes) largest = std::max(largest, lane);
  for (int i = whole; i < count; ++i) {
    const float a = scale_x * x[i];
    const float b = scale_y * y[i];
    const float c = scale_z * z[i];
    largest = std::max(largest, a * a + b * b + c * c);
  }
  return largest;
}

MAILLE_FOR_SEVERAL_WIDTHS
double dot_of_run(const float* a, const float* b, int count) {
  double lanes[kLanes] = {};
  const int whole = count / kLanes * kLanes;
  for (int x = 0; x < whole; x += kLanes) {
    for (int l = 0; l < kLanes; ++l) {
      lanes[l] += static_cast<double>(a[x + l]) * static_cast<double>(b[x + l]);
    }
  }
  for (int x = whole; x < count; ++x) {
    lanes[x - whole] += static_cast<double>(a[x]) * static_cast<double>(b[x]);
  }
  double sum = 0.0;
  for (const double lane : lanes) sum += lane;
  return sum;
}

void laplacian(const SpringBox& box, const SpringRun& run, const std::array<RowsAround, 3>& w,
               RunVectors& out) {
  const Inputs in = inputs_of(box, run);
  if (!in.compliance && !in.missing) {
    return laplacian_plain(w, 1.0f / in.one_compliance, in.count, out);
  }
  if (in.missing) return laplacian_cut(in, box.springs(), box.steps(), w, out);
  laplacian_mixed(in, box.springs(), box.steps(), w, out);
}

void stiffnesses(const SpringBox& box, const SpringRun& run, int spring, float* k) {
  const Inputs in = inputs_of(box, run);
  if (!in.compliance && !in.missing) {
    std::fill(k, k + in.count, 1.0f / in.one_compliance);
    return;
  }
  stiffnesses_mixed(in, box.step(spring), spring, k);
}

}  // namespace maille
