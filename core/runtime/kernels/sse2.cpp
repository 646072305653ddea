#include <immintrin.h>  // not only SSE2: where the compiler is told of more, float_kernels.h uses it

#include "runtime/kernels/pose_kernels.h"

namespace fb::runtime {
namespace {

#include "runtime/kernels/float_kernels.h"

__m128i load(const std::uint8_t* bytes) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes));
}

// Two columns are interleaved to pairs of 16-bit numbers for the multiply-add instruction.
template <int rows, int poses>
void sum_columns(const std::uint8_t* digits, const PanelInputs& panel, std::size_t first_pose,
                 std::int32_t (&sums)[poses][rows]) {
  constexpr int blocks = rows / 16;
  const __m128i zero = _mm_setzero_si128();
  __m128i sum[poses][4 * blocks];
  for (int p = 0; p < poses; ++p)
    for (__m128i& s : sum[p]) s = _mm_set1_epi32(static_cast<int>(panel.initial_sums[first_pose + p]));
  const std::int16_t* inputs = panel.values + 4 * first_pose;
  for (std::size_t k = 0; k < panel.count; k += 4, inputs += 4 * panel.poses)
    for (int pair = 0; pair < 4; pair += 2) {
      const std::uint8_t* a = digits + panel.offsets[k + pair];
      const std::uint8_t* b = digits + panel.offsets[k + pair + 1];
      for (int block = 0; block < blocks; ++block) {
        const __m128i first = _mm_unpacklo_epi8(load(a + 16 * block), load(b + 16 * block));
        const __m128i last = _mm_unpackhi_epi8(load(a + 16 * block), load(b + 16 * block));
        const __m128i weights[4] = {_mm_unpacklo_epi8(first, zero), _mm_unpackhi_epi8(first, zero),
                                    _mm_unpacklo_epi8(last, zero), _mm_unpackhi_epi8(last, zero)};
        for (int p = 0; p < poses; ++p) {
          int numbers;
          __builtin_memcpy(&numbers, inputs + 4 * p + pair, sizeof numbers);
          const __m128i input = _mm_set1_epi32(numbers);
          __m128i* s = sum[p] + 4 * block;
          for (int i = 0; i < 4; ++i) s[i] = _mm_add_epi32(s[i], _mm_madd_epi16(weights[i], input));
        }
      }
    }
  for (int p = 0; p < poses; ++p)
    for (int i = 0; i < 4 * blocks; ++i) _mm_storeu_si128(reinterpret_cast<__m128i*>(sums[p] + 4 * i), sum[p][i]);
}

// Four rows of a quad are a vector.
template <int rows, int poses>
void sum_quads(const std::uint8_t* quads, std::size_t stride, const PanelInputs& panel, std::size_t first_pose,
               std::int32_t (&sums)[poses][rows]) {
  constexpr int vectors = rows / 4;
  const __m128i even = _mm_set1_epi16(255);
  __m128i sum[poses][vectors];
  for (int p = 0; p < poses; ++p)
    for (__m128i& s : sum[p]) s = _mm_set1_epi32(static_cast<int>(panel.initial_sums[first_pose + p]));
  const std::int16_t* inputs = panel.values + 4 * first_pose;
  for (std::size_t k = 0; k < panel.count; k += 4, inputs += 4 * panel.poses, quads += stride)
    for (int v = 0; v < vectors; ++v) {
      const __m128i weights = load(quads + 16 * v);
      const __m128i first = _mm_and_si128(weights, even), last = _mm_srli_epi16(weights, 8);
      for (int p = 0; p < poses; ++p) {
        int numbers[2];
        __builtin_memcpy(numbers, inputs + 4 * p, sizeof numbers);
        sum[p][v] = _mm_add_epi32(sum[p][v], _mm_madd_epi16(first, _mm_set1_epi32(numbers[0])));
        sum[p][v] = _mm_add_epi32(sum[p][v], _mm_madd_epi16(last, _mm_set1_epi32(numbers[1])));
      }
    }
  for (int p = 0; p < poses; ++p)
    for (int v = 0; v < vectors; ++v) _mm_storeu_si128(reinterpret_cast<__m128i*>(sums[p] + 4 * v), sum[p][v]);
}

#include "runtime/kernels/strips.h"

}  // namespace

const PoseKernels sse2_kernels = make_kernels("sse2", column_product<32, 16, 2>, quad_product<32, 16, 2>);

}  // namespace fb::runtime
