// The loops over floats, once for each instruction set: included by its kernels' file, inside an unnamed namespace and
// after panel_kernels.h, so that the compiler makes its vectors of them. What is longer than whole vectors has room up
// to the next multiple of padding.

// Bits of positive floats have the order of the floats, and those of what is not a number come last.
std::int32_t size_of(float x) {
  std::int32_t bits;
  __builtin_memcpy(&bits, &x, sizeof bits);
  return bits & 0x7fffffff;
}

bool any_nan(const float* x, std::size_t count) {
  std::int32_t most = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t size = size_of(x[i]);
    most = size > most ? size : most;
  }
  return most > 0x7f800000;
}

std::uint32_t clamp_controls(const float* __restrict controls, const float* __restrict minimum,
                             const float* __restrict maximum, const float* __restrict rest, std::size_t count,
                             float* __restrict moves, std::size_t step) {
  std::uint32_t clamped = 0;
  const auto clamp = [&](std::size_t i, float& move) {
    const float low = controls[i] < minimum[i] ? minimum[i] : controls[i];
    const float within = low > maximum[i] ? maximum[i] : low;
    clamped += within != controls[i];
    move = within - rest[i];
  };
  if (step == 1)
    for (std::size_t i = 0; i < count; ++i) clamp(i, moves[i]);
  else
    for (std::size_t i = 0; i < count; ++i) clamp(i, moves[i * step]);
  return clamped;
}

void control_features(const ControlFeatures& f, const float* __restrict moves, std::size_t poses,
                      float* __restrict values) {
  if (poses == 1) {
    for (std::size_t i = 0; i < f.count; ++i)
      values[i] = control_feature(f.kinds[i], f.scales[i], f.thresholds[i], f.falls[i], moves[f.controls[i]]);
    return;
  }
  for (std::size_t i = 0; i < f.count; ++i)
    for (std::size_t p = 0; p < block_poses; ++p)
      values[i * block_poses + p] =
          control_feature(f.kinds[i], f.scales[i], f.thresholds[i], f.falls[i], moves[f.controls[i] * block_poses + p]);
}

// Written whether listed or not, because which features are 0 is a coin toss that no branch predictor wins.
std::size_t compact_nonzeros(const float* values, std::size_t count, std::uint32_t* places) {
  std::size_t moved = 0;
  for (std::size_t i = 0; i < count; ++i) {
    places[moved] = static_cast<std::uint32_t>(i);
    moved += size_of(values[i]) != 0;
  }
  return moved;
}

// What the largest size of some numbers counts as; 0 if they all count as 0.
float largest_of(std::int32_t size) {
  constexpr std::int32_t largest = 0x71800000;  // 2^100
  size = size < largest ? size : largest;
  float m;
  __builtin_memcpy(&m, &size, sizeof m);
  return m < 0x1p-100f ? 0 : m;
}

// Rounds to nearest even, by adding 1.5 * 2^23: beyond 2^23 floats are whole.
std::int32_t whole_of(float x, float limit) {
  float q = (x + 12582912.0f) - 12582912.0f;
  q = q > limit ? limit : q;
  q = q < -limit ? -limit : q;
  return static_cast<std::int32_t>(q == q ? q : 0);
}

// FORMAT.md, "Quantise". What lies beyond the numbers is read, since whole vectors are, but counts as 0: setting it to
// 0 first would make the reading wait for it.
Rounded quantise_all(const float* __restrict x, std::size_t count, float limit, std::int16_t* __restrict quantised) {
  const auto end = static_cast<std::int32_t>(count);
  const std::size_t padded = (count + padding - 1) / padding * padding;
  std::int32_t most = 0;
  for (std::size_t i = 0; i < padded; ++i) {
    const std::int32_t size = size_of(x[i]);
    const std::int32_t counted = static_cast<std::int32_t>(i) < end ? size : 0;
    most = counted > most ? counted : most;
  }
  const float m = largest_of(most);
  if (m == 0) return {};
  const float inverse = limit / m;
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < padded; ++i) {
    const std::int32_t all = whole_of(x[i] * inverse, limit);
    const std::int32_t whole = static_cast<std::int32_t>(i) < end ? all : 0;
    quantised[i] = static_cast<std::int16_t>(whole);
    sum += static_cast<std::uint32_t>(whole);
  }
  return {m / limit, sum};
}

// Of eight poses.
using EightWholes = std::int16_t __attribute__((vector_size(16)));
using EightSums = std::uint32_t __attribute__((vector_size(32)));

// Stores four numbers of eight poses pose after pose.
void store_block(const EightWholes (&four)[4], std::int16_t* quantised) {
  static_assert(block_poses == 8);
  const auto [a, b, c, d] = four;
  const EightWholes ab[2] = {__builtin_shufflevector(a, b, 0, 8, 1, 9, 2, 10, 3, 11),
                             __builtin_shufflevector(a, b, 4, 12, 5, 13, 6, 14, 7, 15)};
  const EightWholes cd[2] = {__builtin_shufflevector(c, d, 0, 8, 1, 9, 2, 10, 3, 11),
                             __builtin_shufflevector(c, d, 4, 12, 5, 13, 6, 14, 7, 15)};
  for (int half = 0; half < 2; ++half) {
    const EightWholes first = __builtin_shufflevector(ab[half], cd[half], 0, 1, 8, 9, 2, 3, 10, 11);
    const EightWholes last = __builtin_shufflevector(ab[half], cd[half], 4, 5, 12, 13, 6, 7, 14, 15);
    __builtin_memcpy(quantised + 16 * half, &first, sizeof first);
    __builtin_memcpy(quantised + 16 * half + 8, &last, sizeof last);
  }
}

// x is filled up with zeros to fours of numbers.
void round_block(float* __restrict x, std::size_t count, float limit, std::int16_t* __restrict quantised,
                 Rounded* __restrict rounded) {
  const std::size_t fours = (count + 3) / 4;
  for (std::size_t i = count * block_poses; i < 4 * fours * block_poses; ++i) x[i] = 0;
  std::int32_t most[block_poses] = {};
  for (std::size_t i = 0; i < count; ++i, x += block_poses)
    for (std::size_t p = 0; p < block_poses; ++p) {
      const std::int32_t size = size_of(x[p]);
      most[p] = size > most[p] ? size : most[p];
    }
  x -= count * block_poses;
  float inverse[block_poses];
  for (std::size_t p = 0; p < block_poses; ++p) {
    const float m = largest_of(most[p]);
    inverse[p] = m == 0 ? 0 : limit / m;
    rounded[p].step = m / limit;
  }
  EightSums sums = {};
  for (std::size_t four = 0; four < fours; ++four, quantised += 4 * block_poses) {
    EightWholes found[4];
    for (std::size_t k = 0; k < 4; ++k, x += block_poses) {
      std::int32_t some[block_poses];
      for (std::size_t p = 0; p < block_poses; ++p) some[p] = whole_of(x[p] * inverse[p], limit);
      EightSums eight;
      __builtin_memcpy(&eight, some, sizeof eight);
      sums += eight;
      found[k] = __builtin_convertvector(eight, EightWholes);
    }
    store_block(found, quantised);
  }
  for (std::size_t p = 0; p < block_poses; ++p) rounded[p].sum = sums[p];
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

constexpr PoseKernels with_passes(const char* name, PanelSums column_sums, PanelSums quad_sums) {
  return {name,         column_sums, quad_sums, any_nan,      clamp_controls, control_features, compact_nonzeros,
          quantise_all, round_block, move_rows, finish_layer, to_halves,      normalise};
}
