#include "bake/face/network_inputs.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "bake/analysis/curve_jumps.h"

namespace fb::bake {
namespace {

constexpr std::size_t task_poses = 1024;  // evaluated by one worker at a time
constexpr double scale_power = 1.5;       // see input_scales

float gate_value(const Gate& gate, const float* values) {
  float sum = 0, largest = 0;
  for (const std::uint32_t f : gate.features) {
    const float value = std::abs(values[f]);
    sum += value;
    largest = std::max(largest, value);
  }
  return std::clamp(gate.slope * (sum - largest), 0.0f, 1.0f);
}

}  // namespace

Feature identity_feature(const RigSchema& schema, std::uint32_t control) {
  return {Feature::Kind::identity, control, 1 / schema.controls[control].reach(), 0};
}

std::vector<Feature> identity_features(const RigSchema& schema) {
  std::vector<Feature> features;
  for (std::uint32_t c = 0; c < schema.control_count(); ++c) features.push_back(identity_feature(schema, c));
  return features;
}

std::vector<float> identity_values(std::vector<float> controls, const RigSchema& schema) {
  const std::vector<Feature> features = identity_features(schema);
  for (std::size_t i = 0; i < controls.size(); ++i) {
    const std::size_t c = i % features.size();
    controls[i] = (controls[i] - schema.controls[c].rest) * features[c].scale;
  }
  return controls;
}

RegionInputs region_inputs(const RigAnalysis& analysis, const RigSchema& schema, std::span<const FaceRegion> regions,
                           bool gated) {
  RegionInputs inputs;
  inputs.features = analysis.base.features;
  std::vector<std::uint32_t> identity(schema.control_count(), UINT32_MAX);
  for (const FaceRegion& region : regions)
    for (const std::uint32_t control : region.controls) {
      if (identity[control] != UINT32_MAX) continue;
      identity[control] = static_cast<std::uint32_t>(inputs.features.size());
      inputs.features.push_back(identity_feature(schema, control));
    }
  for (const FaceRegion& region : regions) {
    std::set<std::uint32_t> region_features;
    std::set<std::uint32_t> steps;
    Gate gate;
    for (const std::uint32_t control : region.controls) {
      region_features.insert(identity[control]);
      if (gated) gate.features.push_back(identity[control]);
    }
    for (std::uint32_t f = 0; f < analysis.base.features.size(); ++f)
      if (is_step(analysis.base.features[f]) &&
          std::ranges::binary_search(region.controls, analysis.base.features[f].control))
        steps.insert(f);
    for (const Corrective& corrective : analysis.correctives)
      if (region_features.size() < 2 * region.controls.size() &&
          std::includes(region.controls.begin(), region.controls.end(), corrective.controls.begin(),
                        corrective.controls.end()))
        region_features.insert(corrective.features.begin(), corrective.features.end());
    region_features.merge(steps);
    inputs.of_region.emplace_back(region_features.begin(), region_features.end());
    inputs.gates.push_back(std::move(gate));
  }
  return inputs;
}

std::vector<float> input_scales(std::span<const Feature> features, std::span<const std::uint32_t> of_region,
                                const FaceRegion& region) {
  std::vector<double> motion(features.size());  // features are listed after those they are computed from
  for (std::size_t f = 0; f < features.size(); ++f) {
    const Feature& feature = features[f];
    if (feature.of_features()) {
      motion[f] = std::min(motion[feature.first], motion[feature.second]);
      continue;
    }
    const auto found = std::ranges::lower_bound(region.controls, feature.control);
    if (found != region.controls.end() && *found == feature.control)
      motion[f] = region.motion[static_cast<std::size_t>(found - region.controls.begin())];
  }
  std::vector<float> scales;
  double squares = 0;
  for (const std::uint32_t f : of_region) {
    scales.push_back(static_cast<float>(std::pow(motion[f], scale_power)));
    squares += double(scales.back()) * scales.back();
  }
  if (!(squares > 0)) return {};
  for (float& scale : scales) scale *= static_cast<float>(std::sqrt(double(scales.size()) / squares));
  return scales;
}

std::vector<std::uint32_t> FeatureTable::columns(std::span<const std::uint32_t> of) const {
  std::vector<std::uint32_t> columns;
  for (const std::uint32_t feature : of)
    columns.push_back(
        static_cast<std::uint32_t>(std::lower_bound(features.begin(), features.end(), feature) - features.begin()));
  return columns;
}

FeatureTable feature_table(const RegionInputs& inputs, const RigSchema& schema, std::span<const float> controls,
                           const Parallel& parallel) {
  FeatureTable table;
  std::set<std::uint32_t> used;
  for (const auto& list : inputs.of_region) used.insert(list.begin(), list.end());
  table.features.assign(used.begin(), used.end());
  const std::vector<float> rest = schema.rest_pose();
  const std::size_t count = table.poses = controls.size() / rest.size(), width = table.features.size(),
                    all = inputs.features.size();
  table.values.resize(count * width);
  for (const Gate& gate : inputs.gates) table.gates.emplace_back(gate.features.empty() ? 0 : count);

  const std::size_t blocks = (count + task_poses - 1) / task_poses;
  parallel_for(parallel, blocks, [&](std::size_t b, std::size_t) {
    std::vector<float> values(all);
    for (std::size_t pose = b * task_poses; pose < std::min(count, (b + 1) * task_poses); ++pose) {
      evaluate_features(inputs.features, controls.subspan(pose * rest.size(), rest.size()), rest, values);
      for (std::size_t f = 0; f < width; ++f) table.values[pose * width + f] = values[table.features[f]];
      for (std::size_t r = 0; r < inputs.gates.size(); ++r)
        if (!table.gates[r].empty()) table.gates[r][pose] = gate_value(inputs.gates[r], values.data());
    }
  });
  return table;
}

void keep_live_features(Network& network) {
  std::vector<Feature>& features = network.features;
  std::vector<char> used(features.size());
  const auto mark = [&](const std::vector<std::uint32_t>& list) {
    for (const std::uint32_t f : list) used[f] = 1;
  };
  mark(network.direct);
  for (const Region& region : network.regions) {
    mark(region.features);
    mark(region.gate.features);
  }
  // Features are listed after those they are computed from.
  for (std::size_t f = features.size(); f-- > 0;)
    if (used[f] && features[f].of_features()) used[features[f].first] = used[features[f].second] = 1;

  std::vector<std::uint32_t> new_index(features.size());
  std::vector<Feature> kept;
  for (std::size_t f = 0; f < features.size(); ++f) {
    new_index[f] = static_cast<std::uint32_t>(kept.size());
    if (!used[f]) continue;
    Feature feature = features[f];
    if (feature.of_features()) {
      feature.first = new_index[feature.first];
      feature.second = new_index[feature.second];
    }
    kept.push_back(feature);
  }
  features = std::move(kept);
  const auto renumber = [&](std::vector<std::uint32_t>& list) {
    for (std::uint32_t& f : list) f = new_index[f];
  };
  renumber(network.direct);
  for (Region& region : network.regions) {
    renumber(region.features);
    renumber(region.gate.features);
  }
}

}  // namespace fb::bake
