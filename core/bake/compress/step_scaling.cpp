#include "bake/compress/step_scaling.h"

#include <algorithm>
#include <cmath>

#include "bake/compress/rate_distortion.h"

namespace fb::bake {
namespace {

constexpr int scale_rungs = 41, rungs_to_double = 4;

double factor_at(int rung) {
  return std::exp2(double(rung) / rungs_to_double);
}

// The first rung for which `before` is false, or `scale_rungs`.
int first_rung_not(const std::function<bool(int)>& before) {
  int low = -1, high = scale_rungs;  // before(low), not before(high)
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    (before(middle) ? low : high) = middle;
  }
  return high;
}

}  // namespace

PackedModel with_scaled_steps(const PackedModel& model, double factor) {
  PackedModel out = model;
  if (factor <= 1) return out;
  std::vector<std::vector<float>> exact;
  for (PackedRowBlock& group : out.row_blocks) {
    std::vector<float>& values_of_group = exact.emplace_back();
    const PackedRowBlock before = std::move(group);
    group = {before.first_row, before.row_count, {}, {}};
    for (std::size_t c = 0; c < before.columns.size(); ++c) {
      std::vector<std::int16_t> values(before.values.begin() + c * before.row_count,
                                       before.values.begin() + (c + 1) * before.row_count);
      int most = 0;
      std::vector<float> scaled;
      for (std::int16_t& value : values) {
        scaled.push_back(static_cast<float>(value / factor));
        value = static_cast<std::int16_t>(std::nearbyint(value / factor));
        most = std::max(most, std::abs(int(value)));
      }
      // A narrow value may not leave its range when it is quantised anew: nothing beyond the range is asked for.
      if (most <= largest_narrow)
        for (float& value : scaled) value = std::clamp<float>(value, -largest_narrow, largest_narrow);
      const float scale = static_cast<float>(before.columns[c].scale * factor);
      if (most == 0) continue;
      group.columns.push_back({before.columns[c].column, most > largest_narrow, scale});
      group.values.insert(group.values.end(), values.begin(), values.end());
      values_of_group.insert(values_of_group.end(), scaled.begin(), scaled.end());
    }
  }
  rate_distortion_quantise(out, exact, {});
  return out;
}

StepScaling finest_within_bytes(std::uint64_t max_bytes, const MeasureScaling& measure) {
  if (const StepScaling unchanged = measure(1); unchanged.bytes <= max_bytes) return unchanged;
  const int rung = first_rung_not([&](int r) { return measure(factor_at(r)).bytes > max_bytes; });
  return measure(factor_at(std::min(rung, scale_rungs - 1)));
}

StepScaling coarsest_within_error(double max_error, const MeasureScaling& measure) {
  const int beyond = first_rung_not([&](int r) { return measure(factor_at(r)).error <= max_error; });
  return measure(factor_at(std::max(beyond - 1, 0)));
}

}  // namespace fb::bake
