// Intrinsics that this processor may not have, emulated by SIMDe under their own names, and one that SIMDe lacks.
#pragma once

#define FB_EMULATED  // kernels use only intrinsics that exist here, and no inline assembly
#define SIMDE_ENABLE_NATIVE_ALIASES
#define SIMDE_NO_NATIVE
#include <simde/x86/avx512.h>

inline __m256i _mm256_dpwssd_avx_epi32(__m256i sum, __m256i a, __m256i b) {
  return simde_mm256_dpwssd_epi32(sum, a, b);
}
