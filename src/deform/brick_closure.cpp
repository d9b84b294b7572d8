#include "deform/brick_closure.h"

#include <type_traits>
#include <vector>

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define MAILLE_X86_TARGETS 1
#include <immintrin.h>
#endif

// One source for every width: the loops of the .inl, compiled for what each machine has. Where a
// row of 32 labels of 16 bits is one register (AVX-512BW) it stays in that register. Highway is the
// road not taken: the version that the distribution has can not shift lanes of 16 bits across a
// register, and its every function would have to be cut at the register's width.
namespace maille {
namespace {

namespace portable {
#include "deform/brick_closure.inl"
}  // namespace portable

#if MAILLE_X86_TARGETS
#pragma GCC push_options
#pragma GCC target("avx2,bmi,bmi2,lzcnt,popcnt")
namespace avx2 {
#include "deform/brick_closure.inl"
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512bw,avx512vl,avx512dq,avx2,bmi,bmi2,lzcnt,popcnt")
namespace avx512 {
#include "deform/brick_closure.inl"

// The forms with a mask of all lanes are the same instructions; the others make GCC 12 warn of its
// own header (its bug 105593).
struct RegisterRows {
  using Row = __m512i;
  using Lanes = __mmask32;
  static constexpr __mmask16 kAll32 = 0xffff;
  static constexpr Lanes kAll16 = 0xffffffff;

  static Row load(const std::uint16_t* from) { return _mm512_load_si512(from); }
  static void store(std::uint16_t* to, Row row) { _mm512_store_si512(to, row); }
  static Row splat(std::uint16_t value) { return _mm512_set1_epi16(static_cast<short>(value)); }
  static Row subtract(Row a, Row b) { return _mm512_maskz_subs_epu16(kAll16, a, b); }
  static Row add(Row a, Row b) { return _mm512_maskz_adds_epu16(kAll16, a, b); }
  static Row greater(Row a, Row b) { return _mm512_maskz_max_epu16(kAll16, a, b); }
  static Row lesser(Row a, Row b) { return _mm512_maskz_min_epu16(kAll16, a, b); }
  static std::uint32_t nonzero(Row a) { return _mm512_test_epi16_mask(a, a); }
  static bool any_greater(Row a, Row b) { return _mm512_cmpgt_epu16_mask(a, b) != 0; }
  template <int k>
  static Row shift_up(Row a) {
    if constexpr (k == 1) {
      // A lane of 32 bits takes its upper half from its own lower half, the lower from the one
      // before.
      return _mm512_or_si512(_mm512_maskz_slli_epi32(kAll32, a, 16),
                             _mm512_maskz_srli_epi32(kAll32, words_up<15>(a), 16));
    } else {
      return words_up<16 - k / 2>(a);
    }
  }
  template <int k>
  static Row shift_down(Row a) {
    if constexpr (k == 1) {
      return _mm512_or_si512(_mm512_maskz_srli_epi32(kAll32, a, 16),
                             _mm512_maskz_slli_epi32(kAll32, words_down<1>(a), 16));
    } else {
      return words_down<k / 2>(a);
    }
  }
  static Lanes first_lanes(int count) { return count >= 32 ? kAll16 : (Lanes{1} << count) - 1; }
  static Row mask(Row a, Lanes lanes) { return _mm512_maskz_mov_epi16(lanes, a); }

 private:
  template <int k>
  static Row words_up(Row a) {
    return _mm512_maskz_alignr_epi32(kAll32, a, _mm512_setzero_si512(), k);
  }
  template <int k>
  static Row words_down(Row a) {
    return _mm512_maskz_alignr_epi32(kAll32, _mm512_setzero_si512(), a, k);
  }
};
}  // namespace avx512
#pragma GCC pop_options

bool has_avx2() {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
         __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("lzcnt") &&
         __builtin_cpu_supports("popcnt");
}
bool has_avx512() {
  return has_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq");
}
#endif

// The two jobs, as one version of the code does them.
template <class L>
struct Version {
  void (*close)(L*, Size3, BrickSlack<L>&, DirtyRows&, DirtyRows&);
  MovedLabels<L> (*lower)(L*, Size3, const DirtyRows&, L, std::uint32_t*);
};

template <class L>
std::vector<Version<L>> versions() {
  using Plain = portable::ArrayRows<L>;
  std::vector<Version<L>> all{{portable::close_with<Plain, L>, portable::lower_with<Plain, L>}};
#if MAILLE_X86_TARGETS
  if (has_avx2()) {
    using Wide = avx2::ArrayRows<L>;
    all.push_back({avx2::close_with<Wide, L>, avx2::lower_with<Wide, L>});
  }
  if (has_avx512()) {
    using Widest = std::conditional_t<sizeof(L) == sizeof(std::uint16_t), avx512::RegisterRows,
                                      avx512::ArrayRows<L>>;
    all.push_back({avx512::close_with<Widest, L>, avx512::lower_with<Widest, L>});
  }
#endif
  return all;
}

template <class L>
const Version<L>& version_of(int number) {
  static const std::vector<Version<L>> all = versions<L>();
  return number < 0 ? all.back() : all[static_cast<std::size_t>(number)];
}

}  // namespace

template <class L>
void close_brick(L* labels, Size3 extent, BrickSlack<L>& slack, DirtyRows& dirty,
                 DirtyRows& reached, int version) {
  version_of<L>(version).close(labels, extent, slack, dirty, reached);
}

template <class L>
MovedLabels<L> lower_labels(L* labels, Size3 extent, const DirtyRows& reached, L overshoot,
                            std::uint32_t* moved_rows, int version) {
  return version_of<L>(version).lower(labels, extent, reached, overshoot, moved_rows);
}

int closure_versions() { return static_cast<int>(versions<std::uint16_t>().size()); }

template void close_brick(std::uint16_t*, Size3, BrickSlack<std::uint16_t>&, DirtyRows&, DirtyRows&,
                          int);
template void close_brick(std::uint32_t*, Size3, BrickSlack<std::uint32_t>&, DirtyRows&, DirtyRows&,
                          int);
template MovedLabels<std::uint16_t> lower_labels(std::uint16_t*, Size3, const DirtyRows&,
                                                 std::uint16_t, std::uint32_t*, int);
template MovedLabels<std::uint32_t> lower_labels(std::uint32_t*, Size3, const DirtyRows&,
                                                 std::uint32_t, std::uint32_t*, int);

}  // namespace maille
