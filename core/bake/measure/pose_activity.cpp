#include "bake/measure/pose_activity.h"

#include <algorithm>
#include <cmath>

#include "base/status.h"
#include "model/feature_values.h"

namespace fb::bake {
namespace {

bool gate_closed(const Gate& gate, std::span<const float> features) {
  if (gate.features.empty()) return false;
  float sum = 0, most = 0;
  for (const std::uint32_t f : gate.features) {
    sum += std::abs(features[f]);
    most = std::max(most, std::abs(features[f]));
  }
  return sum - most <= 0;
}

}  // namespace

PoseActivity pose_activity(const PackedModel& model, std::span<const float> controls) {
  const std::size_t width = model.schema.control_count();
  if (controls.size() != width)
    fail(Status::invalid_argument, "a pose of %zu controls for a model of %zu", controls.size(), width);
  PoseActivity pose;
  pose.features.resize(model.features.size());
  feature_values(model.features, controls.data(), model.schema.rest_pose().data(), pose.features.data());
  for (const PackedRegion& region : model.regions) {
    const auto active = std::count_if(region.features.begin(), region.features.end(),
                                      [&](std::uint32_t f) { return pose.features[f] != 0; });
    pose.region_inputs.push_back(gate_closed(region.gate, pose.features) ? 0 : static_cast<std::uint32_t>(active));
  }
  return pose;
}

}  // namespace fb::bake
