#include "bake/face/network_inputs.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace fb::bake {
namespace {

constexpr std::size_t block_poses = 1024;

float gate_value(const Gate& gate, const float* values) {
  float sum = 0, most = 0;
  for (const std::uint32_t f : gate.features) {
    const float size = std::abs(values[f]);
    sum += size;
    most = std::max(most, size);
  }
  return std::clamp(gate.slope * (sum - most), 0.0f, 1.0f);
}

}  // namespace

RegionInputs region_inputs(const RigAnalysis& analysis, const RigSchema& schema, std::span<const FaceRegion> regions,
                           bool gated) {
  RegionInputs inputs;
  inputs.features = analysis.base.features;
  std::vector<std::uint32_t> identity(schema.control_count(), UINT32_MAX);
  for (const FaceRegion& region : regions)
    for (const std::uint32_t control : region.controls) {
      if (identity[control] != UINT32_MAX) continue;
      identity[control] = static_cast<std::uint32_t>(inputs.features.size());
      inputs.features.push_back({Feature::Kind::identity, control, 1 / schema.controls[control].reach(), 0});
    }
  for (const FaceRegion& region : regions) {
    std::set<std::uint32_t> mine;
    Gate gate;
    for (const std::uint32_t control : region.controls) {
      mine.insert(identity[control]);
      if (gated) gate.features.push_back(identity[control]);
    }
    for (const Corrective& corrective : analysis.correctives)
      if (mine.size() < 2 * region.controls.size() &&
          std::includes(region.controls.begin(), region.controls.end(), corrective.controls.begin(),
                        corrective.controls.end()))
        mine.insert(corrective.features.begin(), corrective.features.end());
    inputs.of_region.emplace_back(mine.begin(), mine.end());
    inputs.gates.push_back(std::move(gate));
  }
  return inputs;
}

std::vector<std::uint32_t> FeatureTable::columns(std::span<const std::uint32_t> of) const {
  std::vector<std::uint32_t> places;
  for (const std::uint32_t feature : of)
    places.push_back(
        static_cast<std::uint32_t>(std::lower_bound(features.begin(), features.end(), feature) - features.begin()));
  return places;
}

FeatureTable feature_table(const RegionInputs& inputs, const PoseSet& poses, const Parallel& parallel) {
  FeatureTable table;
  std::set<std::uint32_t> used;
  for (const auto& list : inputs.of_region) used.insert(list.begin(), list.end());
  table.features.assign(used.begin(), used.end());
  const std::size_t count = table.poses = poses.size(), width = table.features.size(), all = inputs.features.size();
  table.values.resize(count * width);
  for (const Gate& gate : inputs.gates) table.gates.emplace_back(gate.features.empty() ? 0 : count);

  const std::vector<float> controls = poses.controls(), rest = poses.source().schema().rest_pose();
  const std::size_t blocks = (count + block_poses - 1) / block_poses;
  parallel_for(parallel, blocks, [&](std::size_t b, std::size_t) {
    std::vector<float> values(all);
    for (std::size_t pose = b * block_poses; pose < std::min(count, (b + 1) * block_poses); ++pose) {
      evaluate_features(inputs.features, std::span(controls).subspan(pose * rest.size(), rest.size()), rest, values);
      for (std::size_t f = 0; f < width; ++f) table.values[pose * width + f] = values[table.features[f]];
      for (std::size_t r = 0; r < inputs.gates.size(); ++r)
        if (!table.gates[r].empty()) table.gates[r][pose] = gate_value(inputs.gates[r], values.data());
    }
  });
  return table;
}

}  // namespace fb::bake
