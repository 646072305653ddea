#include <immintrin.h>

#include "runtime/kernels/pose_kernels.h"

namespace fb::runtime {
namespace {

#include "runtime/kernels/float_kernels.h"

// Inline assembly, because the compiler would delay the additions until it runs out of registers.
__m256i multiply_add(__m256i sum, __m256i weights, __m256i input) {
  const __m256i products = _mm256_madd_epi16(weights, input);
  asm("vpaddd %1, %0, %0" : "+x"(sum) : "x"(products));
  return sum;
}

#include "runtime/kernels/avx2_pairs.h"

}  // namespace

const PoseKernels avx2_kernels =
    make_kernels("avx2", column_product<64, 32, 4>, quad_product<32, 16, 4>, rows_by_piece.position, true);

}  // namespace fb::runtime
