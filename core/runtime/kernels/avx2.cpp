#include <immintrin.h>

#include "runtime/kernels/panel_kernels.h"

namespace fb {
namespace {

#include "runtime/kernels/vector_passes.h"

__m256i load(const std::uint8_t* bytes) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(bytes));
}

// 32 rows a block: two columns become pairs of 16-bit numbers, which one instruction multiplies and adds. Instructions
// that interleave do so within halves of 128 bits, so that sums lie in a wrong order until they are stored.
template <int blocks>
void add_up(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::int32_t* sums) {
  const __m256i zero = _mm256_setzero_si256();
  __m256i sum[4 * blocks];
  for (__m256i& s : sum) s = _mm256_set1_epi32(static_cast<int>(active.start));
  for (std::size_t k = 0; k < active.count; k += 2) {
    const std::uint8_t *a = digits + active.places[k] * rows, *b = digits + active.places[k + 1] * rows;
    int pair;
    __builtin_memcpy(&pair, active.inputs + k, sizeof pair);
    const __m256i input = _mm256_set1_epi32(pair);
    for (int block = 0; block < blocks; ++block) {
      const __m256i x = load(a + 32 * block), y = load(b + 32 * block);
      const __m256i first = _mm256_unpacklo_epi8(x, y), last = _mm256_unpackhi_epi8(x, y);
      __m256i* s = sum + 4 * block;
      s[0] = _mm256_add_epi32(s[0], _mm256_madd_epi16(_mm256_unpacklo_epi8(first, zero), input));
      s[1] = _mm256_add_epi32(s[1], _mm256_madd_epi16(_mm256_unpackhi_epi8(first, zero), input));
      s[2] = _mm256_add_epi32(s[2], _mm256_madd_epi16(_mm256_unpacklo_epi8(last, zero), input));
      s[3] = _mm256_add_epi32(s[3], _mm256_madd_epi16(_mm256_unpackhi_epi8(last, zero), input));
    }
  }
  for (int block = 0; block < blocks; ++block) {
    const __m256i* s = sum + 4 * block;
    auto* to = reinterpret_cast<__m256i*>(sums + 32 * block);
    _mm256_storeu_si256(to, _mm256_permute2x128_si256(s[0], s[1], 0x20));
    _mm256_storeu_si256(to + 1, _mm256_permute2x128_si256(s[2], s[3], 0x20));
    _mm256_storeu_si256(to + 2, _mm256_permute2x128_si256(s[0], s[1], 0x31));
    _mm256_storeu_si256(to + 3, _mm256_permute2x128_si256(s[2], s[3], 0x31));
  }
}

// 16 rows: what is left of a panel.
void add_up_half(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::int32_t* sums) {
  __m256i sum[2] = {_mm256_set1_epi32(static_cast<int>(active.start)),
                    _mm256_set1_epi32(static_cast<int>(active.start))};
  for (std::size_t k = 0; k < active.count; k += 2) {
    const auto* a = reinterpret_cast<const __m128i*>(digits + active.places[k] * rows);
    const auto* b = reinterpret_cast<const __m128i*>(digits + active.places[k + 1] * rows);
    int pair;
    __builtin_memcpy(&pair, active.inputs + k, sizeof pair);
    const __m256i input = _mm256_set1_epi32(pair);
    const __m128i x = _mm_loadu_si128(a), y = _mm_loadu_si128(b);
    sum[0] = _mm256_add_epi32(sum[0], _mm256_madd_epi16(_mm256_cvtepu8_epi16(_mm_unpacklo_epi8(x, y)), input));
    sum[1] = _mm256_add_epi32(sum[1], _mm256_madd_epi16(_mm256_cvtepu8_epi16(_mm_unpackhi_epi8(x, y)), input));
  }
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(sums), sum[0]);
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(sums + 8), sum[1]);
}

void panel_sums(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::int32_t* sums) {
  if (rows == 64) return add_up<2>(digits, rows, active, sums);
  if (rows >= 32) add_up<1>(digits, rows, active, sums);
  if (rows % 32) add_up_half(digits + rows - 16, rows, active, sums + rows - 16);
}

}  // namespace

const PoseKernels avx2_kernels = {"avx2", panel_sums, round_all, move_rows, finish_layer, to_halves, normalise};

}  // namespace fb
