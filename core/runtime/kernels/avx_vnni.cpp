#include <immintrin.h>

#include "runtime/kernels/panel_kernels.h"

namespace fb {
namespace {

#include "runtime/kernels/vector_passes.h"

__m256i multiply_add(__m256i sum, __m256i weights, __m256i input) {
  return _mm256_dpwssd_avx_epi32(sum, weights, input);
}

#include "runtime/kernels/avx2_pairs.h"

}  // namespace

const PoseKernels avx_vnni_kernels = {"avx-vnni", panel_sums,   round_all, round_block,
                                      move_rows,  finish_layer, to_halves, normalise};

}  // namespace fb
