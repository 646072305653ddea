// Instructions that this processor may not have, computed by SIMDe's plain code, under the names kernels call them by;
// and the few SIMDe lacks.
#pragma once

#define SIMDE_ENABLE_NATIVE_ALIASES
#define SIMDE_NO_NATIVE
#include <simde/x86/avx512.h>

using __mmask64 = simde__mmask64;

inline __m512i _mm512_maskz_loadu_epi8(__mmask64 mask, const void* from) {
  unsigned char bytes[64] = {};
  for (int i = 0; i < 64; ++i)
    if (mask >> i & 1) bytes[i] = static_cast<const unsigned char*>(from)[i];
  return simde_mm512_loadu_si512(bytes);
}

inline __m256i _mm256_dpbusd_avx_epi32(__m256i sum, __m256i bytes, __m256i signed_bytes) {
  return simde_mm256_dpbusd_epi32(sum, bytes, signed_bytes);
}

inline __m256i _mm256_dpwssd_avx_epi32(__m256i sum, __m256i a, __m256i b) {
  return simde_mm256_dpwssd_epi32(sum, a, b);
}
