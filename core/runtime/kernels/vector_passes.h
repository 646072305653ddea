// The loops over floats, once for each instruction set: included by its kernels' file, inside an unnamed namespace and
// after panel_kernels.h, so that the compiler makes its vectors of them. What is longer than whole vectors has room up
// to the next multiple of padding.

// FORMAT.md, "Quantise": the whole numbers of x; returns the step. x is filled up with zeros.
float round_all(float* __restrict x, std::size_t count, float limit, std::int32_t* __restrict wholes) {
  const std::size_t padded = (count + padding - 1) / padding * padding;
  for (std::size_t i = count; i < padded; ++i) x[i] = 0;
  // Bits of positive floats have the order of the floats, and those of what is not a number come last.
  constexpr std::int32_t largest = 0x71800000;  // 2^100
  std::int32_t most = 0;
  for (std::size_t i = 0; i < padded; ++i) {
    std::int32_t bits;
    __builtin_memcpy(&bits, x + i, sizeof bits);
    bits &= 0x7fffffff;
    most = bits > most ? bits : most;
  }
  most = most < largest ? most : largest;
  float m;
  __builtin_memcpy(&m, &most, sizeof m);
  if (m < 0x1p-100f) return 0;
  const float inverse = limit / m;
  for (std::size_t i = 0; i < padded; ++i) {
    // Beyond 2^23 floats are whole, so adding 1.5 * 2^23 rounds to nearest even.
    float q = (x[i] * inverse + 12582912.0f) - 12582912.0f;
    q = q > limit ? limit : q;
    q = q < -limit ? -limit : q;
    wholes[i] = static_cast<std::int32_t>(q == q ? q : 0);
  }
  return m / limit;
}

void move_rows(const std::int32_t* __restrict sums, float step, const float* __restrict rest, float* __restrict rows,
               std::size_t count) {
  for (std::size_t r = 0; r < count; ++r) rows[r] = rest[r] + step * static_cast<float>(sums[r]);
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

void finish_layer(const std::int32_t* low, const std::int32_t* high, const float* scales, float step, const float* bias,
                  Activation activation, float* y, std::size_t count) {
  if (high)
    for (std::size_t r = 0; r < count; ++r)
      y[r] = (scales[r] * step) * (256 * static_cast<float>(high[r]) + static_cast<float>(low[r])) + bias[r];
  else
    for (std::size_t r = 0; r < count; ++r) y[r] = (scales[r] * step) * static_cast<float>(low[r]) + bias[r];
  activate(activation, y, count);
}
