// A reference implementation of EVALUATION.md, "What a reader computes": 64-bit integers, dense, no panels. It shares
// no code with the evaluator but the declarations of models.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "model/packed_model.h"

namespace fb::plain {

using Floats = std::vector<float>;
using Digits = std::vector<std::vector<std::int64_t>>;  // by row

inline float positive(float a) {
  return a > 0 ? a : 0;
}

inline float smaller(float a, float b) {
  return a < b ? a : b;
}

inline float tanh(float x) {
  x = x < -7.90531110763549805f ? -7.90531110763549805f : x > 7.90531110763549805f ? 7.90531110763549805f : x;
  const float s = x * x;
  float p = -2.76076847742355e-16f, q = 1.19825839466702e-06f;
  for (const float c : {2.00018790482477e-13f, -8.60467152213735e-11f, 5.12229709037114e-08f, 1.48572235717979e-05f,
                        6.37261928875436e-04f, 4.89352455891786e-03f})
    p = s * p + c;
  for (const float c : {1.18534705686654e-04f, 2.26843463243900e-03f, 4.89352518554385e-03f}) q = s * q + c;
  return x * p / q;
}

inline Floats features(const PackedModel& model, const Floats& controls) {
  using Kind = Feature::Kind;
  Floats values;
  for (const Feature& f : model.features) {
    if (f.kind == Kind::product) {
      const bool none = values[f.first] == 0 || values[f.second] == 0;
      values.push_back(none ? 0 : values[f.first] * values[f.second]);
    } else if (f.kind == Kind::minimum) {
      values.push_back(smaller(values[f.first], values[f.second]));
    } else {
      const Control& c = model.schema.controls[f.control];
      float value = controls[f.control];
      if (value < c.minimum) value = c.minimum;
      if (value > c.maximum) value = c.maximum;
      const float u = value == c.rest ? 0 : (value - c.rest) * f.scale, t = u - f.threshold;
      if (f.kind == Kind::identity) values.push_back(u);
      if (f.kind == Kind::ramp) values.push_back(positive(t));
      if (f.kind == Kind::hat) values.push_back(positive(smaller(t, 1 + (1 - t) * f.fall)));
    }
  }
  return values;
}

inline std::int64_t largest_row_sum(const Digits& digits) {
  std::int64_t most = 0;
  for (const auto& row : digits) {
    std::int64_t sum = 0;
    for (const std::int64_t digit : row) sum += std::abs(digit);
    if (sum > most) most = sum;
  }
  return most;
}

inline std::int64_t limit_of(std::int64_t row_sum) {
  const std::int64_t limit = row_sum ? 2147483647 / row_sum : 32512;
  return limit < 32512 ? limit : 32512;
}

struct Quantised {
  std::vector<std::int64_t> q;
  float step = 0;
};

inline Quantised quantise(const Floats& x, std::int64_t limit) {
  float m = 0;
  for (const float v : x) {
    float size = std::fabs(v);
    if (!(size <= 0x1p100f)) size = 0x1p100f;
    if (size > m) m = size;
  }
  Quantised out{std::vector<std::int64_t>(x.size()), 0};
  if (m < 0x1p-100f) return out;
  out.step = m / float(limit);
  const float inverse = float(limit) / m;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double exact = double(x[i] * inverse);  // of float
    if (std::isnan(exact)) continue;
    const double bounded = exact > double(limit) ? double(limit) : exact < -double(limit) ? -double(limit) : exact;
    double whole = std::floor(bounded);
    const double above = bounded - whole;
    if (above > 0.5 || (above == 0.5 && std::fmod(whole, 2) != 0)) whole += 1;
    out.q[i] = std::int64_t(whole);
  }
  return out;
}

inline std::vector<std::int64_t> multiply(const Digits& digits, const std::vector<std::int64_t>& q) {
  std::vector<std::int64_t> sums;
  for (const auto& row : digits) {
    std::int64_t sum = 0;
    for (std::size_t i = 0; i < row.size(); ++i) sum += row[i] * q[i];
    sums.push_back(sum);
  }
  return sums;
}

// value = base * high + low, low in -base / 2..base / 2 - 1.
inline void split(std::int64_t value, std::int64_t base, std::int64_t& high, std::int64_t& low) {
  high = 0;
  while (value > base / 2 - 1) value -= base, ++high;
  while (value < -base / 2) value += base, --high;
  low = value;
}

// Of the digits of a wide column.
inline std::int64_t base_of(const PackedRowBlock& block, std::size_t column) {
  for (std::int64_t base = 2;; base *= 2) {
    bool fits = true;
    for (std::size_t r = 0; r < block.row_count; ++r)
      if (std::abs(std::int64_t(block.values[column * block.row_count + r])) > 127 * base) fits = false;
    if (fits) return base;
  }
}

inline Floats layer_of(const PackedLayer& layer, const Floats& x) {
  Digits low(layer.outputs, std::vector<std::int64_t>(layer.inputs)), high = low;
  for (std::size_t o = 0; o < layer.outputs; ++o)
    for (std::size_t i = 0; i < layer.inputs; ++i) {
      low[o][i] = layer.weights[o * layer.inputs + i];
      if (layer.wide) split(low[o][i], 256, high[o][i], low[o][i]);
    }
  const std::int64_t low_limit = limit_of(largest_row_sum(low)), high_limit = limit_of(largest_row_sum(high));
  const Quantised in = quantise(x, low_limit < high_limit ? low_limit : high_limit);
  const auto low_sums = multiply(low, in.q), high_sums = multiply(high, in.q);
  Floats y;
  for (std::size_t o = 0; o < layer.outputs; ++o) {
    float sum = float(low_sums[o]);
    if (layer.wide) sum = 256 * float(high_sums[o]) + sum;
    const float scale = layer.scales[o] * in.step;
    float value = scale * sum;
    value = value + layer.bias[o];
    if (layer.activation == Activation::relu) value = positive(value);
    if (layer.activation == Activation::tanh) value = tanh(value);
    if (layer.activation == Activation::silu) value = value * (0.5f + 0.5f * tanh(0.5f * value));
    if (layer.skip) value = value + x[o];
    y.push_back(value);
  }
  return y;
}

inline Floats region_of(const PackedRegion& region, const Floats& all) {
  Floats posed, rest(region.features.size());
  bool resting = true;
  for (const std::uint32_t f : region.features) {
    posed.push_back(all[f]);
    if (all[f] != 0) resting = false;
  }
  for (const PackedLayer& layer : region.layers) {
    posed = layer_of(layer, posed);
    rest = layer_of(layer, rest);
  }
  float sum = 0, most = 0, gate_value = 1;
  for (const std::uint32_t f : region.gate.features) {
    sum = sum + std::fabs(all[f]);
    if (std::fabs(all[f]) > most) most = std::fabs(all[f]);
  }
  if (!region.gate.features.empty()) gate_value = smaller(positive(region.gate.slope * (sum - most)), 1);
  for (std::size_t i = 0; i < posed.size(); ++i)
    posed[i] = resting || gate_value == 0 ? 0 : (posed[i] - rest[i]) * gate_value;
  return posed;
}

inline Floats coefficients(const PackedModel& model, const Floats& controls) {
  const Floats all = features(model, controls);
  Floats coefficients;
  for (const std::uint32_t f : model.direct) coefficients.push_back(all[f]);
  for (const PackedRegion& region : model.regions)
    for (const float c : region_of(region, all)) coefficients.push_back(c);
  return coefficients;
}

inline Floats positions(const PackedModel& model, const Floats& controls) {
  const Floats weights = coefficients(model, controls);
  Floats positions = model.rest.points;
  for (const PackedRowBlock& block : model.row_blocks) {
    Digits digits(block.row_count);
    Floats x;
    for (std::size_t c = 0; c < block.columns.size(); ++c) {
      const PackedColumn& column = block.columns[c];
      const std::int64_t base = base_of(block, c);
      if (column.wide) x.push_back(weights[column.column] * (column.scale * float(base)));
      x.push_back(weights[column.column] * column.scale);
      for (std::size_t r = 0; r < block.row_count; ++r) {
        const std::int64_t value = block.values[c * block.row_count + r];
        std::int64_t high = 0, low = value;
        if (column.wide) split(value, base, high, low);
        if (column.wide) digits[r].push_back(high);
        digits[r].push_back(low);
      }
    }
    const Quantised in = quantise(x, limit_of(largest_row_sum(digits)));
    const auto sums = multiply(digits, in.q);
    for (std::size_t r = 0; r < block.row_count; ++r) {
      const std::size_t row = block.first_row + r;
      const std::size_t at = model.order.empty() ? row : 3 * std::size_t(model.order[row / 3]) + row % 3;
      const float moved = in.step * float(sums[r]);
      if (in.step != 0) positions[at] = positions[at] + moved;
    }
  }
  return positions;
}

}  // namespace fb::plain
