// MAILLE_ONE_OF_WIDTHS: a function template on the number of 16-byte parts of a register, made for
// 16 and 32 bytes; calls go to the widest that the machine has. What it calls must be inlined.
//
// Beside several_widths.h: there the compiler chooses how many neighbours to take at a time, here
// the source says it, where what belongs together is not one number but four. Registers of 64 bytes
// are the road not taken: filling them from eight places took longer than they save (18 ns a voxel
// in place of 13, rest_march.cpp on the machine that this was written on).
#pragma once

namespace maille {

enum class Registers {
  widest,  // that the machine has
  narrow   // 16 bytes, to compare with
};

}  // namespace maille

#if defined(__x86_64__) && defined(__GNUC__)
#define MAILLE_ONE_OF_WIDTHS(Result, name, function, parameters, arguments)                     \
  __attribute__((target("avx2"))) Result name##_32 parameters { return function<2> arguments; } \
  Result name##_16 parameters { return function<1> arguments; }                                 \
  Result name parameters {                                                                      \
    static const bool wide = __builtin_cpu_supports("avx2");                                    \
    return wide ? name##_32 arguments : name##_16 arguments;                                    \
  }
#else
#define MAILLE_ONE_OF_WIDTHS(Result, name, function, parameters, arguments) \
  Result name##_16 parameters { return function<1> arguments; }             \
  Result name parameters { return name##_16 arguments; }
#endif
