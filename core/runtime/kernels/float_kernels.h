// Loops over floats, vectorised by the compiler for each instruction set: included by each kernel file inside an
// unnamed namespace, after pose_kernels.h. Arrays have room up to the next multiple of `padding`.

// Vectors as wide as registers: one or two of four numbers.
#if defined(__AVX__)
constexpr std::size_t lanes = 8;
#else
constexpr std::size_t lanes = 4;
#endif
using Floats = float __attribute__((vector_size(4 * lanes)));
using Integers = std::int32_t __attribute__((vector_size(4 * lanes)));

// The bits of |x|: ordered like the floats, with NaN above infinity.
std::int32_t magnitude_bits(float x) {
  std::int32_t bits;
  __builtin_memcpy(&bits, &x, sizeof bits);
  return bits & 0x7fffffff;
}

bool any_nan(const float* x, std::size_t count) {
  std::int32_t largest = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t size = magnitude_bits(x[i]);
    largest = size > largest ? size : largest;
  }
  return largest > 0x7f800000;
}

std::uint32_t clamp_controls(const float* __restrict controls, const float* __restrict minimum,
                             const float* __restrict maximum, const float* __restrict rest, std::size_t count,
                             float* __restrict offsets, std::size_t stride) {
  std::uint32_t clamped = 0;
  const auto clamp = [&](std::size_t i, float& offset) {
    const float low = controls[i] < minimum[i] ? minimum[i] : controls[i];
    const float within = low > maximum[i] ? maximum[i] : low;
    clamped += within != controls[i];
    offset = within - rest[i];
  };
  if (stride == 1)
    for (std::size_t i = 0; i < count; ++i) clamp(i, offsets[i]);
  else
    for (std::size_t i = 0; i < count; ++i) clamp(i, offsets[i * stride]);
  return clamped;
}

void control_features(const ControlFeatures& f, const float* __restrict offsets, std::size_t poses,
                      float* __restrict values) {
  if (poses == 1) {
    for (std::size_t i = 0; i < f.count; ++i)
      values[i] = control_feature(f.kinds[i], f.scales[i], f.thresholds[i], f.falls[i], offsets[f.controls[i]]);
    return;
  }
  for (std::size_t i = 0; i < f.count; ++i)
    for (std::size_t p = 0; p < poses_per_block; ++p)
      values[i * poses_per_block + p] = control_feature(f.kinds[i], f.scales[i], f.thresholds[i], f.falls[i],
                                                        offsets[f.controls[i] * poses_per_block + p]);
}

// Without a branch: which features are 0 is unpredictable.
std::size_t compact_nonzeros(const float* values, std::size_t count, std::uint32_t* indices) {
  std::size_t found = 0;
  for (std::size_t i = 0; i < count; ++i) {
    indices[found] = static_cast<std::uint32_t>(i);
    found += magnitude_bits(values[i]) != 0;
  }
  return found;
}

// The largest magnitude, given its bits, bounded by 2^100; 0 if below 2^-100.
float largest_magnitude(std::int32_t size) {
  constexpr std::int32_t bound = 0x71800000;  // 2^100
  size = size < bound ? size : bound;
  float m;
  __builtin_memcpy(&m, &size, sizeof m);
  return m < 0x1p-100f ? 0 : m;
}

// Rounds to nearest even by adding 1.5 * 2^23, where the spacing of floats is 1, and clamps to +-limit; NaN gives 0.
std::int32_t round_to_integer(float x, float limit) {
  float q = (x + 12582912.0f) - 12582912.0f;
  q = q > limit ? limit : q;
  q = q < -limit ? -limit : q;
  return static_cast<std::int32_t>(q == q ? q : 0);
}

// EVALUATION.md, "Quantise". Padding is read with whole vectors but counts as 0: clearing it first would stall the
// loads that follow on the stores.
Quantisation quantise(const float* __restrict x, std::size_t count, float limit, std::int16_t* __restrict quantised) {
  const auto end = static_cast<std::int32_t>(count);
  const std::size_t padded = (count + padding - 1) / padding * padding;
  std::int32_t largest = 0;
  for (std::size_t i = 0; i < padded; ++i) {
    const std::int32_t size = magnitude_bits(x[i]);
    const std::int32_t counted = static_cast<std::int32_t>(i) < end ? size : 0;
    largest = counted > largest ? counted : largest;
  }
  const float m = largest_magnitude(largest);
  if (m == 0) return {};
  const float inverse = limit / m;
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < padded; ++i) {
    const std::int32_t rounded = round_to_integer(x[i] * inverse, limit);
    const std::int32_t integer = static_cast<std::int32_t>(i) < end ? rounded : 0;
    quantised[i] = static_cast<std::int16_t>(integer);
    sum += static_cast<std::uint32_t>(integer);
  }
  return {m / limit, sum};
}

// One integer of each of eight poses.
using EightIntegers = std::int16_t __attribute__((vector_size(16)));
using EightSums = std::uint32_t __attribute__((vector_size(32)));

// Transposes four integers of eight poses to eight poses of four integers.
void store_block(const EightIntegers (&four)[4], std::int16_t* quantised) {
  static_assert(poses_per_block == 8);
  const auto [a, b, c, d] = four;
  const EightIntegers ab[2] = {__builtin_shufflevector(a, b, 0, 8, 1, 9, 2, 10, 3, 11),
                               __builtin_shufflevector(a, b, 4, 12, 5, 13, 6, 14, 7, 15)};
  const EightIntegers cd[2] = {__builtin_shufflevector(c, d, 0, 8, 1, 9, 2, 10, 3, 11),
                               __builtin_shufflevector(c, d, 4, 12, 5, 13, 6, 14, 7, 15)};
  for (int half = 0; half < 2; ++half) {
    const EightIntegers first = __builtin_shufflevector(ab[half], cd[half], 0, 1, 8, 9, 2, 3, 10, 11);
    const EightIntegers last = __builtin_shufflevector(ab[half], cd[half], 4, 5, 12, 13, 6, 7, 14, 15);
    __builtin_memcpy(quantised + 16 * half, &first, sizeof first);
    __builtin_memcpy(quantised + 16 * half + 8, &last, sizeof last);
  }
}

void quantise_block(float* __restrict x, std::size_t count, float limit, std::int16_t* __restrict quantised,
                    Quantisation* __restrict results) {
  const std::size_t fours = (count + 3) / 4;
  for (std::size_t i = count * poses_per_block; i < 4 * fours * poses_per_block; ++i) x[i] = 0;
  std::int32_t largest[poses_per_block] = {};
  for (std::size_t i = 0; i < count; ++i, x += poses_per_block)
    for (std::size_t p = 0; p < poses_per_block; ++p) {
      const std::int32_t size = magnitude_bits(x[p]);
      largest[p] = size > largest[p] ? size : largest[p];
    }
  x -= count * poses_per_block;
  float inverse[poses_per_block];
  for (std::size_t p = 0; p < poses_per_block; ++p) {
    const float m = largest_magnitude(largest[p]);
    inverse[p] = m == 0 ? 0 : limit / m;
    results[p].step = m / limit;
  }
  EightSums sums = {};
  for (std::size_t four = 0; four < fours; ++four, quantised += 4 * poses_per_block) {
    EightIntegers integers[4];
    for (std::size_t k = 0; k < 4; ++k, x += poses_per_block) {
      std::int32_t rounded[poses_per_block];
      for (std::size_t p = 0; p < poses_per_block; ++p) rounded[p] = round_to_integer(x[p] * inverse[p], limit);
      EightSums eight;
      __builtin_memcpy(&eight, rounded, sizeof eight);
      sums += eight;
      integers[k] = __builtin_convertvector(eight, EightIntegers);
    }
    store_block(integers, quantised);
  }
  for (std::size_t p = 0; p < poses_per_block; ++p) results[p].sum = sums[p];
}

// A vector of rows from their sums: y = factor * f32(sums) + bias, where factor is scales * step.
[[gnu::always_inline]] inline void finish_vector(const std::int32_t* sums, const float* scales, float step,
                                                 const float* bias, float* y) {
  Integers integers;
  Floats added, factor = Floats{} + step;
  __builtin_memcpy(&integers, sums, sizeof integers);
  __builtin_memcpy(&added, bias, sizeof added);
  if (scales) {
    __builtin_memcpy(&factor, scales, sizeof factor);
    factor *= step;
  }
  const Floats result = factor * __builtin_convertvector(integers, Floats) + added;
  __builtin_memcpy(y, &result, sizeof result);
}

// Rows first..first + count - 1 of a pose of a panel, from their sums; `count` is a multiple of 16.
[[gnu::always_inline]] inline void finish_rows(const Panel& panel, const PanelOutput& output, std::size_t pose,
                                               std::size_t first, std::size_t count, const std::int32_t* sums) {
  const float step = output.steps[pose], *const scales = output.scales, *const bias = output.bias;
  float* const rows = output.rows[pose];
  const std::size_t end = first + count, last = panel.rows;
  for (; first < end; first += lanes, sums += lanes) {
    const float* const factors = scales ? scales + first : nullptr;
    if (first + lanes <= last) {
      finish_vector(sums, factors, step, bias + first, rows + first);
      continue;
    }
    float y[lanes];
    finish_vector(sums, factors, step, bias + first, y);
    for (std::size_t i = 0; first + i < last; ++i) rows[first + i] = y[i];
    return;
  }
}

void activate(Activation activation, float* y, std::size_t count) {
  switch (activation) {
    case Activation::linear:
      return;
    case Activation::relu:
      for (std::size_t i = 0; i < count; ++i) y[i] = y[i] > 0 ? y[i] : 0;
      return;
    case Activation::tanh:
      for (std::size_t i = 0; i < count; ++i) y[i] = rational_tanh(y[i]);
      return;
    case Activation::silu:
      for (std::size_t i = 0; i < count; ++i) y[i] = rational_silu(y[i]);
      return;
  }
}

void join_digits(const float* low, const float* high, const float* scales, float step, const float* bias, float* y,
                 std::size_t count) {
  for (std::size_t r = 0; r < count; ++r) y[r] = (scales[r] * step) * (256 * high[r] + low[r]) + bias[r];
}

#if defined(__F16C__)
// Writes whole vectors. The instruction keeps what a NaN carries; here there is one NaN of each sign.
void convert_to_half(const float* numbers, std::uint16_t* halves, std::size_t count) {
  for (std::size_t i = 0; i < count; i += 8) {
    const __m256 x = _mm256_loadu_ps(numbers + i), signs = _mm256_and_ps(x, _mm256_set1_ps(-0.0f));
    const __m256 nan = _mm256_or_ps(signs, _mm256_set1_ps(__builtin_nanf("")));
    const __m256 known = _mm256_blendv_ps(x, nan, _mm256_cmp_ps(x, x, _CMP_UNORD_Q));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(halves + i), _mm256_cvtps_ph(known, _MM_FROUND_TO_NEAREST_INT));
  }
}
#else
// Rounds to nearest even. Below 2^-14 (denormal halves), adding 0.5 aligns the last bit of a half with that of the
// float; above, the exponent is rebased and the dropped bits round.
void convert_to_half(const float* __restrict numbers, std::uint16_t* __restrict halves, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    std::int32_t bits, small;
    __builtin_memcpy(&bits, numbers + i, sizeof bits);
    const std::int32_t size = bits & 0x7fffffff;
    float shifted;
    __builtin_memcpy(&shifted, &size, sizeof size);
    shifted += 0.5f;
    __builtin_memcpy(&small, &shifted, sizeof small);
    const std::int32_t normal = (size - 0x38000000 + 0xfff + (size >> 13 & 1)) >> 13;
    const std::int32_t overflow = size > 0x7f800000 ? 0x7e00 : 0x7c00;
    const std::int32_t large = size < 0x47800000 ? normal : overflow;
    const std::int32_t half = size < 0x38800000 ? small - 0x3f000000 : large;
    halves[i] = static_cast<std::uint16_t>(half | (bits >> 16 & 0x8000));
  }
}
#endif

#include "runtime/kernels/vertex_kernels.h"
// After it, whose vectors of four it uses.
#include "runtime/kernels/linear_kernels.h"

// The rows of columns as they are.
struct RowsInOrder {
  constexpr RowsInOrder() {
    for (std::size_t row = 0; row < column_group; ++row) position[row] = static_cast<std::uint8_t>(row);
  }
  std::uint8_t position[column_group] = {};
};
[[maybe_unused]] constexpr RowsInOrder rows_in_order;

constexpr PoseKernels make_kernels(const char* name, PanelProduct column_product, PanelProduct quad_product,
                                   const std::uint8_t* column_rows = rows_in_order.position,
                                   bool signed_odd_digits = false) {
  return {name,           column_product,   quad_product,     column_rows,    signed_odd_digits, any_nan,
          clamp_controls, control_features, compact_nonzeros, quantise,       quantise_block,    join_digits,
          activate,       convert_to_half,  quad_areas,       quad_integrals, vertex_normals,    vertex_tangents,
          skin_vertices,  skin_groups,      add_rows,         add_products,   dot_products};
}
