#include <emmintrin.h>

#include "runtime/kernels/panel_kernels.h"

namespace fb {
namespace {

#include "runtime/kernels/vector_passes.h"

__m128i load(const std::uint8_t* bytes) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes));
}

// 16 rows a block, of some poses: two columns become pairs of 16-bit numbers, which one instruction multiplies and
// adds.
template <int blocks, int poses>
void add_up(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::size_t first_pose,
            std::int32_t* sums) {
  const __m128i zero = _mm_setzero_si128();
  __m128i sum[poses][4 * blocks];
  for (int p = 0; p < poses; ++p)
    for (__m128i& s : sum[p]) s = _mm_set1_epi32(static_cast<int>(active.start[first_pose + p]));
  const std::int16_t* inputs = active.inputs + 4 * first_pose;
  for (std::size_t k = 0; k < active.count; k += 4, inputs += 4 * active.poses)
    for (int pair = 0; pair < 4; pair += 2) {
      const std::uint8_t* a = digits + active.places[k + pair] * rows;
      const std::uint8_t* b = digits + active.places[k + pair + 1] * rows;
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
    for (int i = 0; i < 4 * blocks; ++i)
      _mm_storeu_si128(reinterpret_cast<__m128i*>(sums + panel_rows * (first_pose + p) + 4 * i), sum[p][i]);
}

void panel_sums(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::int32_t* sums) {
  std::size_t r = 0;
  if (active.poses == 1)
    for (; r + 32 <= rows; r += 32) add_up<2, 1>(digits + r, rows, active, 0, sums + r);
  for (; r < rows; r += 16)
    if (active.poses == 1)
      add_up<1, 1>(digits + r, rows, active, 0, sums + r);
    else
      for (std::size_t pose = 0; pose < block_poses; pose += 2) add_up<1, 2>(digits + r, rows, active, pose, sums + r);
}

}  // namespace

const PoseKernels sse2_kernels = {"sse2",    panel_sums,   round_all, round_block,
                                  move_rows, finish_layer, to_halves, normalise};

}  // namespace fb
