// The inner loops of relaxation with vectors of 512 bits.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define MAILLE_WIDTH 512
#define MAILLE_FOR_THIS_WIDTH __attribute__((target("arch=x86-64-v4")))
#define MAILLE_HAS_THIS_WIDTH __builtin_cpu_supports("avx512f")
#include "tests/deform/spring_row_widths.inl"
#endif
