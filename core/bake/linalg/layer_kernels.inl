// The bodies of Kernels but gemm, plain loops that the compiler turns into vectors, compiled once per instruction set
// after gemm_kernel.inl. Only builtins and functions that are always inlined are used here: an inline function of the
// library compiled for one set must never be linked in place of another's.
#include "bake/linalg/kernels.h"
#include "model/activation.h"

namespace fb::bake::FB_KERNELS {
namespace {

// What an activation gives and its derivative, from what goes in. Derivatives are those of the functions that the
// rational ones stand for.
struct Bent {
  float value, slope;
};

template <Activation activation>
[[gnu::always_inline]] inline Bent bend(float x) {
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
void bend_columns(std::size_t rows, std::size_t columns, const float* __restrict bias, const float* __restrict skip,
                  float* __restrict y, float* __restrict slope) {
  for (std::size_t i = 0; i < columns; ++i) {
    float* const column = y + i * rows;
    if (slope && skip)
      for (std::size_t k = 0; k < rows; ++k) {
        const Bent bent = bend<activation>(column[k] + bias[k]);
        column[k] = bent.value + skip[i * rows + k];
        slope[i * rows + k] = bent.slope;
      }
    else if (slope)
      for (std::size_t k = 0; k < rows; ++k) {
        const Bent bent = bend<activation>(column[k] + bias[k]);
        column[k] = bent.value;
        slope[i * rows + k] = bent.slope;
      }
    else
      for (std::size_t k = 0; k < rows; ++k)
        column[k] = bend<activation>(column[k] + bias[k]).value + (skip ? skip[i * rows + k] : 0.0f);
  }
}

void activate(Activation activation, std::size_t rows, std::size_t columns, const float* bias, const float* skip,
              float* y, float* slope) {
  switch (activation) {
    case Activation::linear:
      return bend_columns<Activation::linear>(rows, columns, bias, skip, y, slope);
    case Activation::relu:
      return bend_columns<Activation::relu>(rows, columns, bias, skip, y, slope);
    case Activation::tanh:
      return bend_columns<Activation::tanh>(rows, columns, bias, skip, y, slope);
    case Activation::silu:
      return bend_columns<Activation::silu>(rows, columns, bias, skip, y, slope);
  }
}

void backward(std::size_t rows, std::size_t columns, const float* __restrict slope, float* __restrict down,
              float* __restrict up, float* __restrict bias) {
  for (std::size_t i = 0; i < columns; ++i, slope += rows, down += rows) {
    if (up)
      for (std::size_t k = 0; k < rows; ++k) up[i * rows + k] = down[k];
    for (std::size_t k = 0; k < rows; ++k) {
      down[k] *= slope[k];
      bias[k] += down[k];
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
      p[i] = s.decay * p[i] - s.rate * m[i] / (__builtin_sqrtf(v[i]) * s.root_correction + s.epsilon);
    }
  }
}

void round_row(std::size_t count, float levels, const float* __restrict row, float* __restrict rounded) {
  // The largest of every 16th number side by side, as vectors find it.
  float tops[16] = {}, top = 0;
  const auto larger = [](float a, float b) __attribute__((always_inline)) {
    return b > a ? b : a;
  };
  std::size_t i = 0;
  for (; i + 16 <= count; i += 16)
    for (std::size_t j = 0; j < 16; ++j) tops[j] = larger(tops[j], __builtin_fabsf(row[i + j]));
  for (; i < count; ++i) top = larger(top, __builtin_fabsf(row[i]));
  for (const float t : tops) top = larger(top, t);
  const float step = top / levels, steps = top > 0 ? levels / top : 0;
  constexpr float whole = 12582912.0f;  // 1.5 * 2^23: adding it leaves no room for fractions
  for (i = 0; i < count; ++i) rounded[i] = ((row[i] * steps + whole) - whole) * step;
}

}  // namespace

extern const Kernels kernels;
constinit const Kernels kernels = {gemm, activate, backward, adam, round_row};

}  // namespace fb::bake::FB_KERNELS
