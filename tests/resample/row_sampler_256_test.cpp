// The loops over rows of values with vectors of 256 bits.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define MAILLE_WIDTH 256
// Optimised in any build: without that loops stay loops of single numbers, whatever the width.
#define MAILLE_FOR_THIS_WIDTH \
  __attribute__((target("avx2"), optimize("O3", "fp-contract=off", "no-trapping-math")))
#define MAILLE_HAS_THIS_WIDTH __builtin_cpu_supports("avx2")
#include "tests/resample/row_sampler_widths.inl"
#endif
