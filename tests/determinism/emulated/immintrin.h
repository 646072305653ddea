// Instructions that this processor may not have, computed by SIMDe's plain code, under the names kernels call them by;
// and one that SIMDe lacks.
#pragma once

#define FB_EMULATED  // so that kernels keep to intrinsics, and to those there are here
#define SIMDE_ENABLE_NATIVE_ALIASES
#define SIMDE_NO_NATIVE
#include <simde/x86/avx512.h>

inline __m256i _mm256_dpwssd_avx_epi32(__m256i sum, __m256i a, __m256i b) {
  return simde_mm256_dpwssd_epi32(sum, a, b);
}
