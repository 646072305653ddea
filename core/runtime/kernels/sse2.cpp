#include <emmintrin.h>

#include "runtime/kernels/panel_kernels.h"

namespace fb {
namespace {

#include "runtime/kernels/vector_passes.h"

__m128i load(const std::uint8_t* bytes) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes));
}

// 16 rows: two columns become pairs of 16-bit numbers, which one instruction multiplies and adds.
template <int blocks>
void add_up(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::int32_t* sums) {
  const __m128i zero = _mm_setzero_si128();
  __m128i sum[4 * blocks];
  for (__m128i& s : sum) s = _mm_set1_epi32(static_cast<int>(active.start));
  for (std::size_t k = 0; k < active.count; k += 2) {
    const std::uint8_t *a = digits + active.places[k] * rows, *b = digits + active.places[k + 1] * rows;
    const auto low = static_cast<std::uint16_t>(active.inputs[k]);
    const __m128i input = _mm_set1_epi32(active.inputs[k + 1] * 65536 + low);
    for (int block = 0; block < blocks; ++block) {
      const __m128i first = _mm_unpacklo_epi8(load(a + 16 * block), load(b + 16 * block));
      const __m128i last = _mm_unpackhi_epi8(load(a + 16 * block), load(b + 16 * block));
      __m128i* s = sum + 4 * block;
      s[0] = _mm_add_epi32(s[0], _mm_madd_epi16(_mm_unpacklo_epi8(first, zero), input));
      s[1] = _mm_add_epi32(s[1], _mm_madd_epi16(_mm_unpackhi_epi8(first, zero), input));
      s[2] = _mm_add_epi32(s[2], _mm_madd_epi16(_mm_unpacklo_epi8(last, zero), input));
      s[3] = _mm_add_epi32(s[3], _mm_madd_epi16(_mm_unpackhi_epi8(last, zero), input));
    }
  }
  for (int i = 0; i < 4 * blocks; ++i) _mm_storeu_si128(reinterpret_cast<__m128i*>(sums + 4 * i), sum[i]);
}

void panel_sums(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::int32_t* sums) {
  std::size_t r = 0;
  for (; r + 32 <= rows; r += 32) add_up<2>(digits + r, rows, active, sums + r);
  if (r < rows) add_up<1>(digits + r, rows, active, sums + r);
}

}  // namespace

const PoseKernels sse2_kernels = {"sse2", panel_sums, round_all, move_rows, finish_layer, to_halves, normalise};

}  // namespace fb
