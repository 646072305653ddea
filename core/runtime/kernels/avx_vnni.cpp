#include <immintrin.h>

#include "runtime/kernels/pose_kernels.h"

namespace fb::runtime {
namespace {

#include "runtime/kernels/float_kernels.h"

// Inline assembly, because the compiler would copy accumulators between registers.
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

const PoseKernels avx_vnni_kernels =
    make_kernels("avx-vnni", column_product<64, 32, 4>, quad_product<32, 16, 4>, rows_by_piece.position, true);

}  // namespace fb::runtime
