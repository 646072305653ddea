// Which parts of a packed model a pose uses: what its bytes and its time are counted from.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/packed_model.h"

namespace fb::bake {

struct PoseActivity {
  std::vector<float> features;               // values, one a feature
  std::vector<std::uint32_t> region_inputs;  // by region: inputs that are not 0; 0 if its network is skipped
};

// Of a pose of control_count values. A region is skipped if all its inputs are 0 or its gate is closed. Fails with
// invalid_argument on another number of controls.
PoseActivity pose_activity(const PackedModel& model, std::span<const float> controls);

}  // namespace fb::bake
