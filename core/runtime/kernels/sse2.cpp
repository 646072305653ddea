#include <emmintrin.h>

#include "runtime/kernels/panel_kernels.h"

namespace fb::runtime {
namespace {

#include "runtime/kernels/vector_passes.h"

__m128i load(const std::uint8_t* bytes) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes));
}

// 16 rows a block, of some poses: two columns become pairs of 16-bit numbers, which one instruction multiplies and
// adds.
template <int blocks, int poses>
void add_up(const std::uint8_t* digits, const PanelInputs& panel, std::size_t first_pose, std::int32_t* sums) {
  const __m128i zero = _mm_setzero_si128();
  __m128i sum[poses][4 * blocks];
  for (int p = 0; p < poses; ++p)
    for (__m128i& s : sum[p]) s = _mm_set1_epi32(static_cast<int>(panel.start[first_pose + p]));
  const std::int16_t* inputs = panel.inputs + 4 * first_pose;
  for (std::size_t k = 0; k < panel.count; k += 4, inputs += 4 * panel.poses)
    for (int pair = 0; pair < 4; pair += 2) {
      const std::uint8_t* a = digits + panel.places[k + pair] * column_rows;
      const std::uint8_t* b = digits + panel.places[k + pair + 1] * column_rows;
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
      _mm_storeu_si128(reinterpret_cast<__m128i*>(sums + most_rows * (first_pose + p) + 4 * i), sum[p][i]);
}

// Four rows of a quad are a vector.
template <int vectors, int poses>
void add_up_quads(const std::uint8_t* quads, std::size_t rows, const PanelInputs& panel, std::size_t first_pose,
                  std::int32_t* sums) {
  const __m128i even = _mm_set1_epi16(255);
  __m128i sum[poses][vectors];
  for (int p = 0; p < poses; ++p)
    for (__m128i& s : sum[p]) s = _mm_set1_epi32(static_cast<int>(panel.start[first_pose + p]));
  const std::int16_t* inputs = panel.inputs + 4 * first_pose;
  for (std::size_t k = 0; k < panel.count; k += 4, inputs += 4 * panel.poses, quads += 4 * rows)
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
    for (int v = 0; v < vectors; ++v)
      _mm_storeu_si128(reinterpret_cast<__m128i*>(sums + most_rows * (first_pose + p) + 4 * v), sum[p][v]);
}

void column_sums(const std::uint8_t* digits, std::size_t rows, const PanelInputs& panel, std::int32_t* sums) {
  std::size_t r = 0;
  if (panel.poses == 1)
    for (; r + 32 <= rows; r += 32) add_up<2, 1>(digits + r, panel, 0, sums + r);
  for (; r < rows; r += 16)
    if (panel.poses == 1)
      add_up<1, 1>(digits + r, panel, 0, sums + r);
    else
      for (std::size_t pose = 0; pose < block_poses; pose += 2) add_up<1, 2>(digits + r, panel, pose, sums + r);
}

void quad_sums(const std::uint8_t* quads, std::size_t rows, const PanelInputs& panel, std::int32_t* sums) {
  std::size_t r = 0;
  if (panel.poses == 1)
    for (; r + 32 <= rows; r += 32) add_up_quads<8, 1>(quads + 4 * r, rows, panel, 0, sums + r);
  for (; r < rows; r += 16)
    if (panel.poses == 1)
      add_up_quads<4, 1>(quads + 4 * r, rows, panel, 0, sums + r);
    else
      for (std::size_t pose = 0; pose < block_poses; pose += 2)
        add_up_quads<4, 2>(quads + 4 * r, rows, panel, pose, sums + r);
}

}  // namespace

const PoseKernels sse2_kernels = with_passes("sse2", column_sums, quad_sums);

}  // namespace fb::runtime
