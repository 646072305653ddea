#include <immintrin.h>

#include "runtime/kernels/panel_kernels.h"

namespace fb {
namespace {

#include "runtime/kernels/vector_passes.h"

__m256i multiply_add(__m256i sum, __m256i weights, __m256i input) {
  return _mm256_dpwssd_avx_epi32(sum, weights, input);
}

#include "runtime/kernels/avx2_pairs.h"

// 32 bytes, or 16 and zeros.
template <bool whole>
__m256i load(const std::uint8_t* bytes) {
  if constexpr (whole) return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(bytes));
  return _mm256_zextsi128_si256(_mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes)));
}

// 32 rows, or 16, of one pose: four columns become fours of bytes, which one instruction multiplies and adds, with the
// low digits of the four inputs and again with the high ones. Interleaving happens within halves of 128 bits, so that
// sums lie in a wrong order until they are stored.
template <bool whole>
void add_up_fours(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::int32_t* sums) {
  const __m128i low_bytes = _mm_setr_epi8(0, 2, 4, 6, 0, 2, 4, 6, 0, 2, 4, 6, 0, 2, 4, 6);
  const __m128i high_bytes = _mm_setr_epi8(1, 3, 5, 7, 1, 3, 5, 7, 1, 3, 5, 7, 1, 3, 5, 7);
  __m256i low_sum[4], high_sum[4];
  for (__m256i& s : low_sum) s = _mm256_set1_epi32(static_cast<int>(*active.start));
  for (__m256i& s : high_sum) s = _mm256_setzero_si256();
  for (std::size_t k = 0; k < active.count; k += 4) {
    const std::uint32_t* place = active.places + k;
    const __m256i a = load<whole>(digits + place[0] * rows), b = load<whole>(digits + place[1] * rows);
    const __m256i c = load<whole>(digits + place[2] * rows), d = load<whole>(digits + place[3] * rows);
    const __m128i inputs = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(active.inputs + k));
    const __m256i low = _mm256_broadcastsi128_si256(_mm_shuffle_epi8(inputs, low_bytes));
    const __m256i high = _mm256_broadcastsi128_si256(
        _mm_shuffle_epi8(_mm_add_epi16(inputs, _mm_set1_epi16(128)), high_bytes));  // low digits are signed
    const __m256i ab[2] = {_mm256_unpacklo_epi8(a, b), _mm256_unpackhi_epi8(a, b)};
    const __m256i cd[2] = {_mm256_unpacklo_epi8(c, d), _mm256_unpackhi_epi8(c, d)};
    const __m256i fours[4] = {_mm256_unpacklo_epi16(ab[0], cd[0]), _mm256_unpackhi_epi16(ab[0], cd[0]),
                              _mm256_unpacklo_epi16(ab[1], cd[1]), _mm256_unpackhi_epi16(ab[1], cd[1])};
    for (int i = 0; i < 4; ++i) {
      low_sum[i] = _mm256_dpbusd_avx_epi32(low_sum[i], fours[i], low);
      high_sum[i] = _mm256_dpbusd_avx_epi32(high_sum[i], fours[i], high);
    }
  }
  auto* to = reinterpret_cast<__m128i*>(sums);
  for (int i = 0; i < 4; ++i) {
    const __m256i sum = _mm256_add_epi32(low_sum[i], _mm256_slli_epi32(high_sum[i], 8));
    _mm_storeu_si128(to + i, _mm256_castsi256_si128(sum));
    if constexpr (whole) _mm_storeu_si128(to + 4 + i, _mm256_extracti128_si256(sum, 1));
  }
}

void panel_sums(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::int32_t* sums) {
  if (active.poses == block_poses) return block_sums(digits, rows, active, sums);
  std::size_t r = 0;
  for (; r + 32 <= rows; r += 32) add_up_fours<true>(digits + r, rows, active, sums + r);
  if (r < rows) add_up_fours<false>(digits + r, rows, active, sums + r);
}

}  // namespace

const PoseKernels avx_vnni_kernels = {"avx-vnni", panel_sums,   round_all, round_block,
                                      move_rows,  finish_layer, to_halves, normalise};

}  // namespace fb
