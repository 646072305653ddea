// The time that the runtime takes for poses on this machine.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "bake/measure/pose_cost.h"
#include "runtime/evaluator.h"

namespace fb::bake {

// Microseconds of processor time of each pose (poses x control_count values), evaluated one after the other on the
// calling thread: the least of `rounds` over all of them, so that what others on the machine do counts little.
std::vector<double> time_poses(const runtime::Evaluator& evaluator, std::span<const float> controls,
                               std::size_t rounds);

// What a pose of the clip takes on a class of machines, predicted, and on this one, on average.
PoseTime pose_time(const PackedModel& model, const Clip& clip, const MachineClass& machine);

}  // namespace fb::bake
