// The bodies of all Kernels but gemm and gemm_bf16: plain loops that the compiler vectorises, compiled once per instruction set after
// gemm_kernel.inl. They use builtins and always-inlined functions only, because an inline library function compiled for
// one instruction set must never be linked in place of another's.
#include "bake/linalg/kernels.h"
#include "model/activation.h"

namespace fb::bake::FB_KERNELS {
namespace {

// An activation and its derivative. The derivative is that of tanh and silu themselves, which the rational functions of
// the runtime approximate.
struct Activated {
  float value, derivative;
};

template <Activation activation>
[[gnu::always_inline]] inline Activated activate(float x) {
  if constexpr (activation == Activation::relu) return {x < 0 ? 0 : x, x > 0 ? 1.0f : 0.0f};
  if constexpr (activation == Activation::tanh) {
    const float t = rational_tanh(x);
    return {t, 1 - t * t};
  }
  if constexpr (activation == Activation::silu) {
    const float s = 0.5f + 0.5f * rational_tanh(0.5f * x);
    return {x * s, s + x * s * (1 - s)};
  }
  return {x, 1};
}

template <Activation activation>
void activate_columns(std::size_t rows, std::size_t columns, const float* __restrict bias, const float* __restrict skip,
                      float* __restrict y, float* __restrict derivative) {
  for (std::size_t i = 0; i < columns; ++i) {
    float* const column = y + i * rows;
    if (derivative && skip)
      for (std::size_t k = 0; k < rows; ++k) {
        const Activated activated = activate<activation>(column[k] + bias[k]);
        column[k] = activated.value + skip[i * rows + k];
        derivative[i * rows + k] = activated.derivative;
      }
    else if (derivative)
      for (std::size_t k = 0; k < rows; ++k) {
        const Activated activated = activate<activation>(column[k] + bias[k]);
        column[k] = activated.value;
        derivative[i * rows + k] = activated.derivative;
      }
    else
      for (std::size_t k = 0; k < rows; ++k)
        column[k] = activate<activation>(column[k] + bias[k]).value + (skip ? skip[i * rows + k] : 0.0f);
  }
}

void activation_forward(Activation activation, std::size_t rows, std::size_t columns, const float* bias,
                        const float* skip, float* y, float* derivative) {
  switch (activation) {
    case Activation::linear:
      return activate_columns<Activation::linear>(rows, columns, bias, skip, y, derivative);
    case Activation::relu:
      return activate_columns<Activation::relu>(rows, columns, bias, skip, y, derivative);
    case Activation::tanh:
      return activate_columns<Activation::tanh>(rows, columns, bias, skip, y, derivative);
    case Activation::silu:
      return activate_columns<Activation::silu>(rows, columns, bias, skip, y, derivative);
  }
}

void activation_backward(std::size_t rows, std::size_t columns, const float* __restrict derivative,
                         float* __restrict gradient, float* __restrict skip_gradient,
                         float* __restrict bias_gradient) {
  for (std::size_t i = 0; i < columns; ++i, derivative += rows, gradient += rows) {
    if (skip_gradient)
      for (std::size_t k = 0; k < rows; ++k) skip_gradient[i * rows + k] = gradient[k];
    for (std::size_t k = 0; k < rows; ++k) {
      gradient[k] *= derivative[k];
      bias_gradient[k] += gradient[k];
    }
  }
}

void adam(const AdamStep& step, std::size_t first, std::size_t count, const float* const* gradients,
          std::size_t microbatches, float* parameters, float* mean, float* square) {
  constexpr std::size_t block = 256;
  const AdamStep s = step;
  float gradient[block];
  for (std::size_t begin = first; begin < first + count; begin += block) {
    const std::size_t size = first + count - begin < block ? first + count - begin : block;
    for (std::size_t i = 0; i < size; ++i) gradient[i] = 0;
    for (std::size_t g = 0; g < microbatches; ++g) {
      const float* __restrict microbatch = gradients[g] + begin;
      for (std::size_t i = 0; i < size; ++i) gradient[i] += microbatch[i];
    }
    float* __restrict p = parameters + begin;
    float* __restrict m = mean + begin;
    float* __restrict v = square + begin;
    for (std::size_t i = 0; i < size; ++i) {
      m[i] = s.beta1 * m[i] + (1 - s.beta1) * gradient[i];
      v[i] = s.beta2 * v[i] + (1 - s.beta2) * gradient[i] * gradient[i];
      p[i] = s.decay_factor * p[i] -
             s.step_size * m[i] / (__builtin_sqrtf(v[i]) * s.second_moment_correction + s.epsilon);
    }
  }
}

void quantise_row(std::size_t count, float levels, const float* __restrict row, float* __restrict quantised) {
  // The maximum in 16 independent lanes, as vectors compute it.
  float lane_max[16] = {}, max = 0;
  const auto larger = [](float a, float b) __attribute__((always_inline)) {
    return b > a ? b : a;
  };
  std::size_t i = 0;
  for (; i + 16 <= count; i += 16)
    for (std::size_t j = 0; j < 16; ++j) lane_max[j] = larger(lane_max[j], __builtin_fabsf(row[i + j]));
  for (; i < count; ++i) max = larger(max, __builtin_fabsf(row[i]));
  for (const float lane : lane_max) max = larger(max, lane);
  const float step = max / levels, inverse = max > 0 ? levels / max : 0;
  constexpr float round_to_integer = 12582912.0f;  // 1.5 * 2^23: adding it leaves no bits for fractions
  for (i = 0; i < count; ++i)
    quantised[i] = ((row[i] * inverse + round_to_integer) - round_to_integer) * step;
}

// Vectors of the instruction set, and as many poses at a time as leave their sums in registers.
#ifdef __AVX512F__
constexpr std::size_t vector_lanes = 16, poses_at_once = 16;
#elif defined(__AVX2__)
constexpr std::size_t vector_lanes = 8, poses_at_once = 4;
#else
constexpr std::size_t vector_lanes = 4, poses_at_once = 2;
#endif

void add_up_block(std::size_t count, const std::uint32_t* __restrict terms, const std::uint32_t* __restrict features,
                  const SixteenFloats* __restrict offsets, const SixteenFloats* __restrict values,
                  SixteenFloats* __restrict sums) {
  // The compiler's vectors: an array of plain floats would stay in memory.
  using Vector = float __attribute__((vector_size(4 * vector_lanes), may_alias));
  constexpr std::size_t vectors = SixteenFloats::count / vector_lanes;
  constexpr std::size_t ahead = 16;  // terms, as far as they are fetched before they are needed
  for (std::size_t first = 0; first < SixteenFloats::count; first += poses_at_once) {
    Vector sum[poses_at_once][vectors] = {};
    for (std::size_t n = 0; n < count; ++n) {
      const std::uint32_t next = terms[n + ahead < count ? n + ahead : count - 1];
      __builtin_prefetch(&offsets[next]);
      __builtin_prefetch(&values[features[next]]);
      const Vector* const offset = reinterpret_cast<const Vector*>(&offsets[terms[n]]);
      const float* const value = values[features[terms[n]]].values + first;
#pragma GCC unroll 16
      for (std::size_t i = 0; i < poses_at_once; ++i)
#pragma GCC unroll 4
        for (std::size_t v = 0; v < vectors; ++v) sum[i][v] += value[i] * offset[v];
    }
    for (std::size_t i = 0; i < poses_at_once; ++i)
      for (std::size_t v = 0; v < vectors; ++v) reinterpret_cast<Vector*>(&sums[first + i])[v] = sum[i][v];
  }
}

}  // namespace

extern const Kernels kernels;
constinit const Kernels kernels = {gemm, gemm,         activation_forward, activation_backward,
                                   adam, quantise_row, add_up_block};

}  // namespace fb::bake::FB_KERNELS
