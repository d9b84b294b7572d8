// MAILLE_FOR_SEVERAL_WIDTHS: compile a function for several vector widths and take the widest that
// the machine has when the program starts. What it calls must be inlined into it.
#pragma once

// The loader's choice between the versions does not get along with the thread sanitizer, which is
// not up yet when it is made.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__)
#define MAILLE_FOR_SEVERAL_WIDTHS \
  __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define MAILLE_FOR_SEVERAL_WIDTHS
#endif
