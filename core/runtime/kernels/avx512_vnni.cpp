#include <immintrin.h>

#include "runtime/kernels/pose_kernels.h"

namespace fb::runtime {
namespace {

#include "runtime/kernels/float_kernels.h"

__m512i broadcast_pair(const std::int16_t* inputs) {
  int numbers;
  __builtin_memcpy(&numbers, inputs, sizeof numbers);
  return _mm512_set1_epi32(numbers);
}

// sum += weights x inputs, for pairs of 16-bit numbers and for fours of bytes. Inline assembly, because the compiler
// would copy accumulators between registers.
__m512i add_pairs(__m512i sum, __m512i weights, __m512i inputs) {
#if defined(FB_EMULATED)
  return _mm512_dpwssd_epi32(sum, weights, inputs);
#else
  asm("vpdpwssd %2, %1, %0" : "+v"(sum) : "v"(weights), "v"(inputs));
  return sum;
#endif
}
__m512i add_fours(__m512i sum, __m512i weights, __m512i inputs) {
#if defined(FB_EMULATED)
  return _mm512_dpbusd_epi32(sum, weights, inputs);
#else
  asm("vpdpbusd %2, %1, %0" : "+v"(sum) : "v"(weights), "v"(inputs));
  return sum;
#endif
}

// Accumulators of 64 rows. Two columns are interleaved two rows at a time (`first`: the low half of each 128-bit lane,
// `last`: the high half); even bytes belong to even rows and odd bytes to odd rows.
struct Strip {
  __m512i first_even, first_odd, last_even, last_odd;

  void begin(std::uint32_t start) {
    first_even = first_odd = last_even = last_odd = _mm512_set1_epi32(static_cast<int>(start));
  }
  void add(const std::uint8_t* a, const std::uint8_t* b, __m512i input) {
    const __m512i x = _mm512_loadu_si512(a), y = _mm512_loadu_si512(b), even = _mm512_set1_epi16(255);
    const __m512i first = _mm512_unpacklo_epi16(x, y), last = _mm512_unpackhi_epi16(x, y);
    first_even = add_pairs(first_even, _mm512_and_si512(first, even), input);
    first_odd = add_pairs(first_odd, _mm512_srli_epi16(first, 8), input);
    last_even = add_pairs(last_even, _mm512_and_si512(last, even), input);
    last_odd = add_pairs(last_odd, _mm512_srli_epi16(last, 8), input);
  }
  void store(std::int32_t* sums) const {
    const __m512i sum[4] = {_mm512_unpacklo_epi32(first_even, first_odd), _mm512_unpackhi_epi32(first_even, first_odd),
                            _mm512_unpacklo_epi32(last_even, last_odd), _mm512_unpackhi_epi32(last_even, last_odd)};
    const __m512i even[2] = {_mm512_shuffle_i32x4(sum[0], sum[1], 0x88), _mm512_shuffle_i32x4(sum[2], sum[3], 0x88)};
    const __m512i odd[2] = {_mm512_shuffle_i32x4(sum[0], sum[1], 0xdd), _mm512_shuffle_i32x4(sum[2], sum[3], 0xdd)};
    _mm512_storeu_si512(sums, _mm512_shuffle_i32x4(even[0], even[1], 0x88));
    _mm512_storeu_si512(sums + 16, _mm512_shuffle_i32x4(odd[0], odd[1], 0x88));
    _mm512_storeu_si512(sums + 32, _mm512_shuffle_i32x4(even[0], even[1], 0xdd));
    _mm512_storeu_si512(sums + 48, _mm512_shuffle_i32x4(odd[0], odd[1], 0xdd));
  }
};

// Adjacent strips.
template <int strips>
struct Strips {
  Strips<strips - 1> before;
  Strip strip;

  void begin(std::uint32_t start) {
    before.begin(start);
    strip.begin(start);
  }
  void add(const std::uint8_t* a, const std::uint8_t* b, __m512i input) {
    before.add(a, b, input);
    strip.add(a + 64 * (strips - 1), b + 64 * (strips - 1), input);
  }
  void store(std::int32_t* sums) const {
    before.store(sums);
    strip.store(sums + 64 * (strips - 1));
  }
};
template <>
struct Strips<0> {
  void begin(std::uint32_t) {}
  void add(const std::uint8_t*, const std::uint8_t*, __m512i) {}
  void store(std::int32_t*) const {}
};

template <int strips>
void sum_columns(const std::uint8_t* digits, const PanelInputs& panel, std::int32_t* sums) {
  Strips<strips> sum;
  sum.begin(*panel.initial_sums);
  const std::uint32_t* index = panel.indices;
  const std::int16_t* input = panel.values;
  for (std::size_t k = 0; k < panel.count; k += 2, index += 2, input += 2)
    sum.add(digits + column_panel_rows * index[0], digits + column_panel_rows * index[1], broadcast_pair(input));
  sum.store(sums);
}

// Sums of 64 rows in four poses of a block.
void sum_columns_of_four(const std::uint8_t* digits, const PanelInputs& panel, std::size_t first_pose,
                         std::int32_t* sums) {
  Strip sum[4];
  for (int p = 0; p < 4; ++p) sum[p].begin(panel.initial_sums[first_pose + p]);
  const std::uint32_t* index = panel.indices;
  const std::int16_t* inputs = panel.values + 4 * first_pose;
  for (std::size_t k = 0; k < panel.count; k += 4, index += 4, inputs += 4 * poses_per_block)
    for (int pair = 0; pair < 4; pair += 2)
      for (int p = 0; p < 4; ++p)
        sum[p].add(digits + column_panel_rows * index[pair], digits + column_panel_rows * index[pair + 1],
                   broadcast_pair(inputs + 4 * p + pair));
  for (int p = 0; p < 4; ++p) sum[p].store(sums + max_panel_rows * (first_pose + p));
}

void column_sums(const std::uint8_t* digits, std::size_t rows, const PanelInputs& panel, std::int32_t* sums) {
  if (panel.poses == 1) {
    if (rows > 128) return sum_columns<3>(digits, panel, sums);
    if (rows > 64) return sum_columns<2>(digits, panel, sums);
    return sum_columns<1>(digits, panel, sums);
  }
  for (std::size_t row = 0; row < rows; row += 64)
    for (std::size_t pose = 0; pose < poses_per_block; pose += 4)
      sum_columns_of_four(digits + row, panel, pose, sums + row);
}

// Sums of 16 * vectors rows, with the low and high digits of the inputs apart.
template <int vectors>
void sum_quads(const std::uint8_t* quads, std::size_t rows, const PanelInputs& panel, std::int32_t* sums) {
  const __m512i low_digits = _mm512_set1_epi32(0x06020400), high_digits = _mm512_set1_epi32(0x07030501);
  const __m512i carry = _mm512_set1_epi16(128);
  __m512i low[vectors], high[vectors];
  for (int v = 0; v < vectors; ++v) low[v] = high[v] = _mm512_setzero_si512();
  const std::int16_t* inputs = panel.values;
  for (std::size_t k = 0; k < panel.count; k += 4, inputs += 4, quads += 4 * rows) {
    long long numbers;
    __builtin_memcpy(&numbers, inputs, sizeof numbers);
    const __m512i four = _mm512_set1_epi64(numbers);
    const __m512i x = _mm512_shuffle_epi8(four, low_digits);
    const __m512i y = _mm512_shuffle_epi8(_mm512_add_epi16(four, carry), high_digits);
    for (int v = 0; v < vectors; ++v) {
      const __m512i weights = _mm512_loadu_si512(quads + 64 * v);
      low[v] = add_fours(low[v], weights, x);
      high[v] = add_fours(high[v], weights, y);
    }
  }
  const __m512i start = _mm512_set1_epi32(static_cast<int>(*panel.initial_sums));
  for (int v = 0; v < vectors; ++v) {
    const __m512i sum = _mm512_add_epi32(low[v], _mm512_slli_epi32(high[v], 8));
    _mm512_storeu_si512(sums + 16 * v, _mm512_add_epi32(sum, start));
  }
}

// Sums of 16 * vectors rows in a block of poses.
template <int vectors>
void sum_quads_of_block(const std::uint8_t* quads, std::size_t rows, const PanelInputs& panel, std::int32_t* sums) {
  const __m512i even = _mm512_set1_epi16(255);
  __m512i sum[vectors * poses_per_block];
  for (std::size_t p = 0; p < poses_per_block; ++p)
    for (int v = 0; v < vectors; ++v) sum[vectors * p + v] = _mm512_set1_epi32(static_cast<int>(panel.initial_sums[p]));
  const std::int16_t* inputs = panel.values;
  for (std::size_t k = 0; k < panel.count; k += 4, quads += 4 * rows) {
    __m512i first[vectors], last[vectors];
    for (int v = 0; v < vectors; ++v) {
      const __m512i weights = _mm512_loadu_si512(quads + 64 * v);
      first[v] = _mm512_and_si512(weights, even);
      last[v] = _mm512_srli_epi16(weights, 8);
    }
    for (std::size_t p = 0; p < poses_per_block; ++p, inputs += 4) {
      const __m512i x = broadcast_pair(inputs), y = broadcast_pair(inputs + 2);
      for (int v = 0; v < vectors; ++v) {
        sum[vectors * p + v] = add_pairs(sum[vectors * p + v], first[v], x);
        sum[vectors * p + v] = add_pairs(sum[vectors * p + v], last[v], y);
      }
    }
  }
  for (std::size_t p = 0; p < poses_per_block; ++p)
    for (int v = 0; v < vectors; ++v) _mm512_storeu_si512(sums + max_panel_rows * p + 16 * v, sum[vectors * p + v]);
}

void quad_sums(const std::uint8_t* quads, std::size_t rows, const PanelInputs& panel, std::int32_t* sums) {
  if (panel.poses == 1) switch (rows / 16) {
      case 8:
        return sum_quads<8>(quads, rows, panel, sums);
      case 7:
        return sum_quads<7>(quads, rows, panel, sums);
      case 6:
        return sum_quads<6>(quads, rows, panel, sums);
      case 5:
        return sum_quads<5>(quads, rows, panel, sums);
      case 4:
        return sum_quads<4>(quads, rows, panel, sums);
      case 3:
        return sum_quads<3>(quads, rows, panel, sums);
      case 2:
        return sum_quads<2>(quads, rows, panel, sums);
      default:
        return sum_quads<1>(quads, rows, panel, sums);
    }
  std::size_t row = 0;
  for (; row + 32 <= rows; row += 32) sum_quads_of_block<2>(quads + 4 * row, rows, panel, sums + row);
  if (row < rows) sum_quads_of_block<1>(quads + 4 * row, rows, panel, sums + row);
}

// SIMDe lacks some of these intrinsics.
#if !defined(FB_EMULATED)
std::size_t compact_nonzeros_masked(const float* values, std::size_t count, std::uint32_t* indices) {
  __m512i index = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  std::size_t found = 0;
  for (std::size_t i = 0; i < count; i += 16) {
    const auto present = static_cast<__mmask16>(count - i < 16 ? 0xffff >> (16 - (count - i)) : 0xffff);
    const __m512i bits = _mm512_maskz_loadu_epi32(present, values + i);
    const __mmask16 mask = _mm512_test_epi32_mask(bits, _mm512_set1_epi32(0x7fffffff));
    _mm512_storeu_si512(indices + found, _mm512_maskz_compress_epi32(mask, index));
    found += static_cast<std::size_t>(__builtin_popcount(mask));
    index = _mm512_add_epi32(index, _mm512_set1_epi32(16));
  }
  return found;
}

// quantise() with masked vectors: most arrays are short.
Quantisation quantise_masked(const float* x, std::size_t count, float limit, std::int16_t* quantised) {
  const auto present = [&](std::size_t i) {
    return static_cast<__mmask16>(count - i < 16 ? (1u << (count - i)) - 1 : 0xffff);
  };
  const __m512i no_sign = _mm512_set1_epi32(0x7fffffff);
  __m512i sizes = _mm512_setzero_si512();
  for (std::size_t i = 0; i < count; i += 16)
    sizes = _mm512_max_epi32(sizes, _mm512_and_si512(_mm512_maskz_loadu_epi32(present(i), x + i), no_sign));
  const float m = largest_magnitude(_mm512_reduce_max_epi32(sizes));
  if (m == 0) return {};
  const __m512 inverse = _mm512_set1_ps(limit / m), most = _mm512_set1_ps(limit), least = _mm512_set1_ps(-limit);
  const __m512 magic = _mm512_set1_ps(12582912.0f);
  __m512i sum = _mm512_setzero_si512();
  for (std::size_t i = 0; i < count; i += 16) {
    __m512 q = _mm512_mul_ps(_mm512_maskz_loadu_ps(present(i), x + i), inverse);
    q = _mm512_sub_ps(_mm512_add_ps(q, magic), magic);
    q = _mm512_max_ps(least, _mm512_min_ps(most, q));
    const __m512i integer = _mm512_maskz_cvttps_epi32(_mm512_cmp_ps_mask(q, q, _CMP_ORD_Q), q);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(quantised + i), _mm512_cvtepi32_epi16(integer));
    sum = _mm512_add_epi32(sum, integer);
  }
  return {m / limit, static_cast<std::uint32_t>(_mm512_reduce_add_epi32(sum))};
}
#endif

constexpr PoseKernels kernels() {
  PoseKernels kernels = make_kernels("avx512-vnni", column_sums, quad_sums);
#if !defined(FB_EMULATED)
  kernels.compact_nonzeros = compact_nonzeros_masked;
  kernels.quantise = quantise_masked;
#endif
  return kernels;
}

}  // namespace

const PoseKernels avx512_vnni_kernels = kernels();

}  // namespace fb::runtime
