#include <immintrin.h>

#include "runtime/kernels/panel_kernels.h"

namespace fb {
namespace {

#include "runtime/kernels/vector_passes.h"

// A column's digits, 16 rows a block, and anything up to 64. Masked loads would be slower.
template <int blocks>
__m512i load(const std::uint8_t* digits) {
  const auto quarter = [&](int q) { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(digits) + q); };
  if constexpr (blocks == 1) return _mm512_castsi128_si512(quarter(0));
  if constexpr (blocks == 4) return _mm512_loadu_si512(digits);
  const __m256i half = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(digits));
  if constexpr (blocks == 2) return _mm512_castsi256_si512(half);
  return _mm512_inserti32x4(_mm512_castsi256_si512(half), quarter(2), 2);
}

// Of sums as add_up() has them: even and odd rows of what was interleaved first, and of what was last, within quarters.
template <int blocks>
void store(const __m512i (&pairs)[4], std::int32_t* sums) {
  const __m512i sum[4] = {_mm512_unpacklo_epi32(pairs[0], pairs[1]), _mm512_unpackhi_epi32(pairs[0], pairs[1]),
                          _mm512_unpacklo_epi32(pairs[2], pairs[3]), _mm512_unpackhi_epi32(pairs[2], pairs[3])};
  const __m512i even[2] = {_mm512_shuffle_i32x4(sum[0], sum[1], 0x88), _mm512_shuffle_i32x4(sum[2], sum[3], 0x88)};
  const __m512i odd[2] = {_mm512_shuffle_i32x4(sum[0], sum[1], 0xdd), _mm512_shuffle_i32x4(sum[2], sum[3], 0xdd)};
  _mm512_storeu_si512(sums, _mm512_shuffle_i32x4(even[0], even[1], 0x88));
  if constexpr (blocks > 1) _mm512_storeu_si512(sums + 16, _mm512_shuffle_i32x4(odd[0], odd[1], 0x88));
  if constexpr (blocks > 2) _mm512_storeu_si512(sums + 32, _mm512_shuffle_i32x4(even[0], even[1], 0xdd));
  if constexpr (blocks > 3) _mm512_storeu_si512(sums + 48, _mm512_shuffle_i32x4(odd[0], odd[1], 0xdd));
}

// Sums of some poses. Two columns become pairs of 16 bits, interleaved by two rows at a time, of which even bytes are
// the one row's and odd bytes the other's. Where poses are few, columns take turns between `turns` sums, so that none
// waits for the one before.
template <int blocks, int poses>
void add_up(const std::uint8_t* digits, const ActiveColumns& active, std::size_t first_pose, std::int32_t* sums) {
  constexpr std::size_t rows = 16 * blocks;
  constexpr int turns = poses == 1 ? 2 : 1;
  const __m512i even = _mm512_set1_epi16(255);
  __m512i sum[poses * turns][4];
  for (int p = 0; p < poses * turns; ++p)
    for (__m512i& s : sum[p])
      s = p < poses ? _mm512_set1_epi32(static_cast<int>(active.start[first_pose + p])) : _mm512_setzero_si512();
  const std::int16_t* inputs = active.inputs + 4 * first_pose;
  for (std::size_t k = 0; k < active.count; k += 4, inputs += 4 * active.poses)
    for (int pair = 0; pair < 4; pair += 2) {
      const std::size_t at[2] = {active.places[k + pair] * rows, active.places[k + pair + 1] * rows};
      if (active.ahead && first_pose == 0)
        for (const std::size_t offset : at) __builtin_prefetch(active.ahead + offset);
      const __m512i a = load<blocks>(digits + at[0]), b = load<blocks>(digits + at[1]);
      const __m512i first = _mm512_unpacklo_epi16(a, b), last = _mm512_unpackhi_epi16(a, b);
      const __m512i pairs[4] = {_mm512_and_si512(first, even), _mm512_srli_epi16(first, 8),
                                _mm512_and_si512(last, even), _mm512_srli_epi16(last, 8)};
      for (int p = 0; p < poses; ++p) {
        int numbers;
        __builtin_memcpy(&numbers, inputs + 4 * p + pair, sizeof numbers);
        const __m512i input = _mm512_set1_epi32(numbers);
        __m512i(&s)[4] = sum[p + pair / 2 % turns * poses];
        for (int i = 0; i < 4; ++i) s[i] = _mm512_dpwssd_epi32(s[i], pairs[i], input);
      }
    }
  for (int p = 0; p < poses; ++p) {
    if constexpr (turns == 2)
      for (int i = 0; i < 4; ++i) sum[p][i] = _mm512_add_epi32(sum[p][i], sum[p + poses][i]);
    store<blocks>(sum[p], sums + panel_rows * (first_pose + p));
  }
}

template <int blocks>
void add_up_all(const std::uint8_t* digits, const ActiveColumns& active, std::int32_t* sums) {
  if (active.poses == 1) return add_up<blocks, 1>(digits, active, 0, sums);
  for (std::size_t pose = 0; pose < block_poses; pose += 4) add_up<blocks, 4>(digits, active, pose, sums);
}

void panel_sums(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::int32_t* sums) {
  if (rows == 64) return add_up_all<4>(digits, active, sums);
  if (rows == 48) return add_up_all<3>(digits, active, sums);
  if (rows == 32) return add_up_all<2>(digits, active, sums);
  add_up_all<1>(digits, active, sums);
}

}  // namespace

const PoseKernels avx512_vnni_kernels = {"avx512-vnni", panel_sums,   round_all, round_block,
                                         move_rows,     finish_layer, to_halves, normalise};

}  // namespace fb
