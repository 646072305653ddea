#include "bake/compress/step_scaling.h"

#include <algorithm>
#include <cmath>

#include "bake/compress/rate_distortion.h"

namespace fb::bake {
namespace {

constexpr int rungs = 41, rungs_to_double = 4;

double factor_at(int rung) {
  return std::exp2(double(rung) / rungs_to_double);
}

}  // namespace

PackedModel with_scaled_steps(const PackedModel& model, double factor) {
  PackedModel out = model;
  if (factor <= 1) return out;
  std::vector<std::vector<float>> exact;
  for (PackedRowBlock& group : out.groups) {
    std::vector<float>& values_of_group = exact.emplace_back();
    const PackedRowBlock before = std::move(group);
    group = {before.first_row, before.row_count, {}, {}};
    for (std::size_t c = 0; c < before.columns.size(); ++c) {
      std::vector<std::int16_t> values(before.values.begin() + c * before.row_count,
                                       before.values.begin() + (c + 1) * before.row_count);
      int most = 0;
      std::vector<float> wanted;
      for (std::int16_t& value : values) {
        wanted.push_back(static_cast<float>(value / factor));
        value = static_cast<std::int16_t>(std::nearbyint(value / factor));
        most = std::max(most, std::abs(int(value)));
      }
      const float scale = static_cast<float>(before.columns[c].scale * factor);
      if (most == 0) continue;
      group.columns.push_back({before.columns[c].column, most > largest_narrow, scale});
      group.values.insert(group.values.end(), values.begin(), values.end());
      values_of_group.insert(values_of_group.end(), wanted.begin(), wanted.end());
    }
  }
  rate_distortion_quantise(out, exact, bits_per_squared_step);
  return out;
}

StepScaling choose_step_scaling(std::uint64_t max_bytes, double max_error,
                                const std::function<std::uint64_t(double)>& bytes,
                                const std::function<double(double)>& error) {
  // Invariant: rungs up to `low` are too fine (or, for an error, allowed), those from `high` on are not.
  const auto before = [&](int rung) {
    return max_bytes > 0 ? bytes(factor_at(rung)) > max_bytes : error(factor_at(rung)) <= max_error;
  };
  int low = -1, high = rungs;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    (before(middle) ? low : high) = middle;
  }
  const int rung = std::clamp(max_bytes > 0 ? high : low, 0, rungs - 1);
  return {factor_at(rung), bytes(factor_at(rung)), error(factor_at(rung))};
}

}  // namespace fb::bake
