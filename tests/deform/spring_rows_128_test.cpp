// The inner loops of relaxation with vectors of 128 bits.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define MAILLE_WIDTH 128
#define MAILLE_FOR_THIS_WIDTH __attribute__((target("sse2")))
#define MAILLE_HAS_THIS_WIDTH __builtin_cpu_supports("sse2")
#include "tests/deform/spring_row_widths.inl"
#endif
