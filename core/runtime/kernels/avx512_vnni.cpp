#include <immintrin.h>

#include "runtime/kernels/panel_kernels.h"

namespace fb {
namespace {

#include "runtime/kernels/vector_passes.h"

// Up to 64 rows at once, of one or two poses; those there are not are neither read nor stored. Four columns become
// fours of bytes, which one instruction multiplies and adds, with the low digits of the four inputs and again with the
// high ones. Interleaving happens within quarters of 128 bits, so that sums lie in a wrong order until they are stored.
template <int poses>
void add_up(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::size_t first_pose,
            std::int32_t* sums) {
  const __mmask64 there = ~__mmask64(0) >> (64 - rows);
  const __m128i low_bytes = _mm_setr_epi8(0, 2, 4, 6, 0, 2, 4, 6, 0, 2, 4, 6, 0, 2, 4, 6);
  const __m128i high_bytes = _mm_setr_epi8(1, 3, 5, 7, 1, 3, 5, 7, 1, 3, 5, 7, 1, 3, 5, 7);
  __m512i low_sum[poses][4], high_sum[poses][4];
  for (int p = 0; p < poses; ++p)
    for (int i = 0; i < 4; ++i) {
      low_sum[p][i] = _mm512_set1_epi32(static_cast<int>(active.start[first_pose + p]));
      high_sum[p][i] = _mm512_setzero_si512();
    }
  const std::int16_t* numbers = active.inputs + 4 * first_pose;
  for (std::size_t k = 0; k < active.count; k += 4, numbers += 4 * active.poses) {
    const std::uint32_t* place = active.places + k;
    if (active.ahead && first_pose == 0)
      for (int i = 0; i < 4; ++i) __builtin_prefetch(active.ahead + place[i] * rows);
    const __m512i a = _mm512_maskz_loadu_epi8(there, digits + place[0] * rows);
    const __m512i b = _mm512_maskz_loadu_epi8(there, digits + place[1] * rows);
    const __m512i c = _mm512_maskz_loadu_epi8(there, digits + place[2] * rows);
    const __m512i d = _mm512_maskz_loadu_epi8(there, digits + place[3] * rows);
    const __m512i ab[2] = {_mm512_unpacklo_epi8(a, b), _mm512_unpackhi_epi8(a, b)};
    const __m512i cd[2] = {_mm512_unpacklo_epi8(c, d), _mm512_unpackhi_epi8(c, d)};
    const __m512i fours[4] = {_mm512_unpacklo_epi16(ab[0], cd[0]), _mm512_unpackhi_epi16(ab[0], cd[0]),
                              _mm512_unpacklo_epi16(ab[1], cd[1]), _mm512_unpackhi_epi16(ab[1], cd[1])};
    for (int p = 0; p < poses; ++p) {
      const __m128i inputs = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(numbers + 4 * p));
      const __m512i low = _mm512_broadcast_i32x4(_mm_shuffle_epi8(inputs, low_bytes));
      const __m512i high = _mm512_broadcast_i32x4(
          _mm_shuffle_epi8(_mm_add_epi16(inputs, _mm_set1_epi16(128)), high_bytes));  // low digits are signed
      for (int i = 0; i < 4; ++i) {
        low_sum[p][i] = _mm512_dpbusd_epi32(low_sum[p][i], fours[i], low);
        high_sum[p][i] = _mm512_dpbusd_epi32(high_sum[p][i], fours[i], high);
      }
    }
  }
  for (int p = 0; p < poses; ++p)
    for (int i = 0; i < 4; ++i) {
      const __m512i sum = _mm512_add_epi32(low_sum[p][i], _mm512_slli_epi32(high_sum[p][i], 8));
      auto* to = reinterpret_cast<__m128i*>(sums + panel_rows * (first_pose + p)) + i;
      _mm_storeu_si128(to, _mm512_castsi512_si128(sum));
      if (rows > 16) _mm_storeu_si128(to + 4, _mm512_extracti32x4_epi32(sum, 1));
      if (rows > 32) _mm_storeu_si128(to + 8, _mm512_extracti32x4_epi32(sum, 2));
      if (rows > 48) _mm_storeu_si128(to + 12, _mm512_extracti32x4_epi32(sum, 3));
    }
}

void panel_sums(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::int32_t* sums) {
  if (active.poses == 1) return add_up<1>(digits, rows, active, 0, sums);
  for (std::size_t pose = 0; pose < block_poses; pose += 2) add_up<2>(digits, rows, active, pose, sums);
}

}  // namespace

const PoseKernels avx512_vnni_kernels = {"avx512-vnni", panel_sums, round_all, move_rows,
                                         finish_layer,  to_halves,  normalise};

}  // namespace fb
