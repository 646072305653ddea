// Sums of rows of floats and dot products, in one order whatever the width of vectors: included by float_kernels.h
// inside an unnamed namespace.

#if defined(__AVX512F__)
using WideFloats = float __attribute__((vector_size(64)));
#else
using WideFloats = Floats;
#endif
constexpr std::size_t wide_lanes = sizeof(WideFloats) / sizeof(float);

// A few rows of sums, so many vectors of each in registers while products are added.
template <std::size_t sums, std::size_t vectors>
[[gnu::always_inline]] inline void add_few_products(float* to, std::size_t to_stride, const float* factors,
                                                    std::size_t factor_stride, const float* rows, std::size_t stride,
                                                    std::size_t count) {
  WideFloats sum[sums][vectors];
  for (std::size_t s = 0; s < sums; ++s) __builtin_memcpy(sum[s], to + s * to_stride, sizeof sum[s]);
  for (std::size_t k = 0; k < count; ++k) {
    WideFloats row[vectors];
    __builtin_memcpy(row, rows + k * stride, sizeof row);
    for (std::size_t s = 0; s < sums; ++s)
      for (std::size_t v = 0; v < vectors; ++v) sum[s][v] += factors[s * factor_stride + k] * row[v];
  }
  for (std::size_t s = 0; s < sums; ++s) __builtin_memcpy(to + s * to_stride, sum[s], sizeof sum[s]);
}

template <std::size_t vectors>
[[gnu::always_inline]] inline void add_products_of(const ProductRows& to, const ProductRows& factors, const float* rows,
                                                   std::size_t stride, std::size_t count) {
  std::size_t s = 0;
  for (; s + 2 <= to.count; s += 2)
    add_few_products<2, vectors>(to.first + s * to.stride, to.stride, factors.first + s * factors.stride,
                                 factors.stride, rows, stride, count);
  if (s < to.count)
    add_few_products<1, vectors>(to.first + s * to.stride, 0, factors.first + s * factors.stride, 0, rows, stride,
                                 count);
}

void add_products(const ProductRows& to, const ProductRows& factors, const float* rows, std::size_t stride,
                  std::size_t count, std::size_t length) {
  constexpr std::size_t most = 4 * wide_lanes;
  std::size_t i = 0;
  const auto part = [&] { return ProductRows{to.first + i, to.stride, to.count}; };
  for (; i + most <= length; i += most) add_products_of<4>(part(), factors, rows + i, stride, count);
  for (; i < length; i += padding) add_products_of<padding / wide_lanes>(part(), factors, rows + i, stride, count);
}

void add_rows(float* to, const float* factors, const float* rows, std::size_t stride, std::size_t count,
              std::size_t length) {
  constexpr std::size_t most = 8 * wide_lanes;
  std::size_t i = 0;
  for (; i + most <= length; i += most) add_few_products<1, 8>(to + i, 0, factors, 0, rows + i, stride, count);
  for (; i < length; i += padding)
    add_few_products<1, padding / wide_lanes>(to + i, 0, factors, 0, rows + i, stride, count);
}

// Sum i of 16 takes every 16th product from the i-th on; then halves are added to each other.
template <std::size_t count>
[[gnu::always_inline]] inline void few_dot_products(const float* x, const float* rows, std::size_t stride,
                                                    std::size_t length, float* sums) {
  constexpr std::size_t vectors = padding / lanes;
  Floats partial[count][vectors] = {};
  for (std::size_t i = 0; i < length; i += padding)
    for (std::size_t k = 0; k < count; ++k)
      for (std::size_t v = 0; v < vectors; ++v) {
        Floats a, b;
        __builtin_memcpy(&a, x + i + v * lanes, sizeof a);
        __builtin_memcpy(&b, rows + k * stride + i + v * lanes, sizeof b);
        partial[k][v] += a * b;
      }
  for (std::size_t k = 0; k < count; ++k) {
    for (std::size_t v = 0; v < vectors / 2; ++v) partial[k][v] += partial[k][v + vectors / 2];
    Four halves[2];
    __builtin_memcpy(halves, partial[k], sizeof halves);
    const Four sum = halves[0] + halves[1];
    sums[k] = (sum[0] + sum[2]) + (sum[1] + sum[3]);
  }
}

void dot_products(const float* x, const float* rows, std::size_t stride, std::size_t count, std::size_t length,
                  float* sums) {
  constexpr std::size_t at_once = lanes == 8 ? 4 : 2;
  std::size_t k = 0;
  for (; k + at_once <= count; k += at_once) few_dot_products<at_once>(x, rows + k * stride, stride, length, sums + k);
  for (; k < count; ++k) few_dot_products<1>(x, rows + k * stride, stride, length, sums + k);
}
