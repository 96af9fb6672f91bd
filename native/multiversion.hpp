// Hot loops are compiled once for every x86-64 and again for wider vectors; the loader picks.
// Contraction is off (CMakeLists.txt), so that all versions round alike and agree in each cell.
#pragma once

#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GLIBC__) && defined(__GNUC__) && \
    !defined(__clang__)
#define CIRCUMSPECT_MULTIVERSION \
  __attribute__((noinline, target_clones("default", "avx2", "avx512f")))
#else
#define CIRCUMSPECT_MULTIVERSION
#endif

// Before a loop whose arrays do not overlap, where the compiler can not see that.
#if defined(__GNUC__) && !defined(__clang__)
#define CIRCUMSPECT_NO_OVERLAP _Pragma("GCC ivdep")
#else
#define CIRCUMSPECT_NO_OVERLAP
#endif
