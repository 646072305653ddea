// The loops over floats, once for each instruction set: included by its kernels' file, inside an unnamed namespace and
// after panel_kernels.h, so that the compiler makes its vectors of them. What is longer than whole vectors has room up
// to the next multiple of padding.

// FORMAT.md, "Quantise". x is filled up with zeros.
Rounded round_all(float* __restrict x, std::size_t count, float limit, std::int16_t* __restrict wholes) {
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
  if (m < 0x1p-100f) return {};
  const float inverse = limit / m;
  std::uint32_t sum = 0, zeros = 0;
  for (std::size_t i = 0; i < padded; ++i) {
    // Beyond 2^23 floats are whole, so adding 1.5 * 2^23 rounds to nearest even.
    float q = (x[i] * inverse + 12582912.0f) - 12582912.0f;
    q = q > limit ? limit : q;
    q = q < -limit ? -limit : q;
    const auto whole = static_cast<std::int32_t>(q == q ? q : 0);
    wholes[i] = static_cast<std::int16_t>(whole);
    sum += static_cast<std::uint32_t>(whole);
    zeros += whole == 0;
  }
  return {m / limit, sum, zeros - static_cast<std::uint32_t>(padded - count)};
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

// To the nearest of 16 bits, ties to the even one. Below 2^-14, adding 0.5 leaves a half's last bit the last of the
// sum; above, the exponent is moved and the bits that fall off decide.
void to_halves(const float* __restrict numbers, std::uint16_t* __restrict halves, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    std::int32_t bits, small;
    __builtin_memcpy(&bits, numbers + i, sizeof bits);
    const std::int32_t size = bits & 0x7fffffff;
    float shifted;
    __builtin_memcpy(&shifted, &size, sizeof size);
    shifted += 0.5f;
    __builtin_memcpy(&small, &shifted, sizeof small);
    const std::int32_t ordinary = (size - 0x38000000 + 0xfff + (size >> 13 & 1)) >> 13;
    const std::int32_t beyond = size > 0x7f800000 ? 0x7e00 : 0x7c00;
    const std::int32_t large = size < 0x47800000 ? ordinary : beyond;
    const std::int32_t half = size < 0x38800000 ? small - 0x3f000000 : large;
    halves[i] = static_cast<std::uint16_t>(half | (bits >> 16 & 0x8000));
  }
}

// Makes vectors one long; null where they have no finite length.
void normalise(float* __restrict x, float* __restrict y, float* __restrict z, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const float square = x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
    const bool sound = square > 0 && square <= 0x1.fffffep127f;
    const float scale = 1 / __builtin_sqrtf(square);
    x[i] = sound ? x[i] * scale : 0;
    y[i] = sound ? y[i] * scale : 0;
    z[i] = sound ? z[i] * scale : 0;
  }
}
