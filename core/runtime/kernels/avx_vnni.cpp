#include <immintrin.h>

#include "runtime/kernels/panel_kernels.h"

namespace fb::runtime {
namespace {

#include "runtime/kernels/vector_passes.h"

// The assembler is one instruction the compiler could choose itself, were it not to move sums about.
__m256i multiply_add(__m256i sum, __m256i weights, __m256i input) {
#if defined(FB_EMULATED)
  return _mm256_dpwssd_avx_epi32(sum, weights, input);
#else
  asm("%{vex%} vpdpwssd %2, %1, %0" : "+x"(sum) : "x"(weights), "x"(input));
  return sum;
#endif
}

#include "runtime/kernels/avx2_pairs.h"

}  // namespace

const PoseKernels avx_vnni_kernels = with_passes("avx-vnni", column_sums, quad_sums);

}  // namespace fb::runtime
