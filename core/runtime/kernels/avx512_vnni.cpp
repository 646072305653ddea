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

// Writes rows of a pose of a panel from their sums, 16 at a time.
class RowWriter {
 public:
  RowWriter(const Panel& panel, const PanelOutput& output, std::size_t pose)
      : scales_(output.scales),
        bias_(output.bias),
        rows_(output.rows[pose]),
        count_(panel.rows),
        step_(_mm512_set1_ps(output.steps[pose])) {}

  [[gnu::always_inline]] void write(std::size_t row, __m512i sums) const {
    if (row >= count_) return;
    const __m512 factor = scales_ ? _mm512_mul_ps(_mm512_loadu_ps(scales_ + row), step_) : step_;
    const __m512 product = _mm512_mul_ps(factor, _mm512_cvtepi32_ps(sums));
    const __m512 result = _mm512_add_ps(product, _mm512_loadu_ps(bias_ + row));
    if (row + 16 <= count_)
      _mm512_storeu_ps(rows_ + row, result);
    else
      _mm512_mask_storeu_ps(rows_ + row, static_cast<__mmask16>((1u << (count_ - row)) - 1), result);
  }

 private:
  const float *scales_, *bias_;
  float* rows_;
  std::size_t count_;
  __m512 step_;
};

// GCC would load again for each use.
__m512i load_once(const std::uint8_t* bytes) {
  __m512i loaded = _mm512_loadu_si512(bytes);
#if !defined(FB_EMULATED)
  asm("" : "+v"(loaded));
#endif
  return loaded;
}

// Where rows of a column are stored. Interleaving two columns two rows at a time leaves four groups of 16 rows: the
// even and the odd rows of the low and of the high halves of the 128-bit lanes. So that a group has consecutive rows,
// these are stored apart.
struct RowsByLane {
  constexpr RowsByLane() {
    for (unsigned row = 0; row < column_group; ++row)
      position[row] = static_cast<std::uint8_t>(row % 16 / 4 * 16 + row / 32 * 8 + row % 4 * 2 + row / 16 % 2);
  }
  std::uint8_t position[column_group] = {};
};
constexpr RowsByLane rows_by_lane;

// Accumulators of 64 rows of a pose. Even rows are summed with 256 times the odd ones behind them. Loops over several
// of them are unrolled, because GCC would keep an array in memory.
struct Strip {
  __m512i first_both, first_odd, last_both, last_odd;

  void begin(std::uint32_t start) {
    first_both = last_both = _mm512_set1_epi32(static_cast<int>(start));
    first_odd = last_odd = _mm512_setzero_si512();
  }
  void add(const std::uint8_t* a, const std::uint8_t* b, __m512i input) {
    const __m512i x = load_once(a), y = load_once(b);
    const __m512i first = _mm512_unpacklo_epi16(x, y), last = _mm512_unpackhi_epi16(x, y);
    first_both = add_pairs(first_both, first, input);
    first_odd = add_pairs(first_odd, _mm512_srai_epi16(first, 8), input);
    last_both = add_pairs(last_both, last, input);
    last_odd = add_pairs(last_odd, _mm512_srai_epi16(last, 8), input);
  }
  void finish(const RowWriter& writer, std::size_t row) const {
    writer.write(row, _mm512_sub_epi32(first_both, _mm512_slli_epi32(first_odd, 8)));
    writer.write(row + 16, first_odd);
    writer.write(row + 32, _mm512_sub_epi32(last_both, _mm512_slli_epi32(last_odd, 8)));
    writer.write(row + 48, last_odd);
  }
};

template <int strips>
void add_columns(const Panel& panel, const PanelInputs& inputs, const PanelOutput& output) {
  Strip sum[strips];
#pragma GCC unroll 3
  for (Strip& strip : sum) strip.begin(*inputs.initial_sums);
  const std::uint32_t* at = inputs.offsets;
  const std::int16_t* input = inputs.values;
  for (std::size_t k = 0; k < inputs.count; k += 2, at += 2, input += 2) {
    const std::uint8_t *const a = panel.digits + at[0], *const b = panel.digits + at[1];
    const __m512i pair = broadcast_pair(input);
#pragma GCC unroll 3
    for (int s = 0; s < strips; ++s) sum[s].add(a + 64 * s, b + 64 * s, pair);
  }
  const RowWriter writer(panel, output, 0);
#pragma GCC unroll 3
  for (int s = 0; s < strips; ++s) sum[s].finish(writer, 64 * static_cast<std::size_t>(s));
}

// 64 rows in four poses of a block.
void add_columns_of_four(const Panel& panel, std::size_t row, const PanelInputs& inputs, std::size_t first_pose,
                         const PanelOutput& output) {
  Strip sum[4];
#pragma GCC unroll 4
  for (int p = 0; p < 4; ++p) sum[p].begin(inputs.initial_sums[first_pose + p]);
  const std::uint8_t* const digits = panel.digits + row;
  const std::uint32_t* at = inputs.offsets;
  const std::int16_t* values = inputs.values + 4 * first_pose;
  for (std::size_t k = 0; k < inputs.count; k += 4, at += 4, values += 4 * poses_per_block)
    for (int pair = 0; pair < 4; pair += 2)
#pragma GCC unroll 4
      for (int p = 0; p < 4; ++p)
        sum[p].add(digits + at[pair], digits + at[pair + 1], broadcast_pair(values + 4 * p + pair));
#pragma GCC unroll 4
  for (std::size_t p = 0; p < 4; ++p) sum[p].finish({panel, output, first_pose + p}, row);
}

void column_product(const Panel& panel, const PanelInputs& inputs, const PanelOutput& output) {
  if (inputs.poses == 1) {
    if (panel.rows > 128) return add_columns<3>(panel, inputs, output);
    if (panel.rows > 64) return add_columns<2>(panel, inputs, output);
    return add_columns<1>(panel, inputs, output);
  }
  for (std::size_t row = 0; row < panel.rows; row += 64)
    for (std::size_t pose = 0; pose < poses_per_block; pose += 4) add_columns_of_four(panel, row, inputs, pose, output);
}

// 16 * vectors rows, with the low and high digits of the inputs apart.
template <int vectors>
void add_quads(const Panel& panel, const PanelInputs& inputs, const PanelOutput& output) {
  const __m512i low_digits = _mm512_set1_epi32(0x06020400), high_digits = _mm512_set1_epi32(0x07030501);
  const __m512i carry = _mm512_set1_epi16(128);
  __m512i low[vectors], high[vectors];
#pragma GCC unroll 8
  for (int v = 0; v < vectors; ++v) low[v] = high[v] = _mm512_setzero_si512();
  const std::int16_t* values = inputs.values;
  const std::uint8_t* quads = panel.digits;
  for (std::size_t k = 0; k < inputs.count; k += 4, values += 4, quads += panel.stride) {
    long long numbers;
    __builtin_memcpy(&numbers, values, sizeof numbers);
    const __m512i four = _mm512_set1_epi64(numbers);
    const __m512i x = _mm512_shuffle_epi8(four, low_digits);
    const __m512i y = _mm512_shuffle_epi8(_mm512_add_epi16(four, carry), high_digits);
#pragma GCC unroll 8
    for (int v = 0; v < vectors; ++v) {
      const __m512i weights = _mm512_loadu_si512(quads + 64 * v);
      low[v] = add_fours(low[v], weights, x);
      high[v] = add_fours(high[v], weights, y);
    }
  }
  const __m512i start = _mm512_set1_epi32(static_cast<int>(*inputs.initial_sums));
  const RowWriter writer(panel, output, 0);
#pragma GCC unroll 8
  for (int v = 0; v < vectors; ++v) {
    const __m512i sum = _mm512_add_epi32(low[v], _mm512_slli_epi32(high[v], 8));
    writer.write(16 * static_cast<std::size_t>(v), _mm512_add_epi32(sum, start));
  }
}

// 16 * vectors rows, from `row` on, in a block of poses.
template <int vectors>
void add_quads_of_block(const Panel& panel, std::size_t row, const PanelInputs& inputs, const PanelOutput& output) {
  const __m512i even = _mm512_set1_epi16(255);
  __m512i sum[poses_per_block][vectors];
#pragma GCC unroll 8
  for (std::size_t p = 0; p < poses_per_block; ++p)
#pragma GCC unroll 2
    for (__m512i& s : sum[p]) s = _mm512_set1_epi32(static_cast<int>(inputs.initial_sums[p]));
  const std::int16_t* values = inputs.values;
  const std::uint8_t* quads = panel.digits + 4 * row;
  for (std::size_t k = 0; k < inputs.count; k += 4, quads += panel.stride) {
    __m512i first[vectors], last[vectors];
    for (int v = 0; v < vectors; ++v) {
      const __m512i weights = _mm512_loadu_si512(quads + 64 * v);
      first[v] = _mm512_and_si512(weights, even);
      last[v] = _mm512_srli_epi16(weights, 8);
    }
#pragma GCC unroll 8
    for (std::size_t p = 0; p < poses_per_block; ++p, values += 4) {
      const __m512i x = broadcast_pair(values), y = broadcast_pair(values + 2);
      for (int v = 0; v < vectors; ++v) {
        sum[p][v] = add_pairs(sum[p][v], first[v], x);
        sum[p][v] = add_pairs(sum[p][v], last[v], y);
      }
    }
  }
#pragma GCC unroll 8
  for (std::size_t p = 0; p < poses_per_block; ++p) {
    const RowWriter writer(panel, output, p);
    for (std::size_t v = 0; v < vectors; ++v) writer.write(row + 16 * v, sum[p][v]);
  }
}

void quad_product(const Panel& panel, const PanelInputs& inputs, const PanelOutput& output) {
  if (inputs.poses == 1) {
    static constexpr PanelProduct by_vectors[] = {add_quads<1>, add_quads<2>, add_quads<3>, add_quads<4>,
                                                  add_quads<5>, add_quads<6>, add_quads<7>, add_quads<8>};
    return by_vectors[(panel.rows - 1) / 16](panel, inputs, output);
  }
  std::size_t row = 0;
  for (; row + 16 < panel.rows; row += 32) add_quads_of_block<2>(panel, row, inputs, output);
  if (row < panel.rows) add_quads_of_block<1>(panel, row, inputs, output);
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
  PoseKernels kernels = make_kernels("avx512-vnni", column_product, quad_product, rows_by_lane.position, true);
#if !defined(FB_EMULATED)
  kernels.compact_nonzeros = compact_nonzeros_masked;
  kernels.quantise = quantise_masked;
#endif
  return kernels;
}

}  // namespace

const PoseKernels avx512_vnni_kernels = kernels();

}  // namespace fb::runtime
