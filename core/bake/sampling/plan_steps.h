// The steps of sampling that have one probe of the rig between them.
#pragma once

#include <functional>

#include "bake/sampling/control_responses.h"
#include "bake/sampling/sampling.h"

namespace fb::bake {

// Poses a new dataset's shards are measured by, at most.
inline constexpr std::size_t timed_poses = 1 + 8 + 64;

// Fails on what cannot be planned, without asking the rig.
void check_request(const Source& rig, const SamplingOptions& options);

// make_plan for a rig that was probed.
PosePlan make_plan(const Source& rig, const ControlResponses& responses, const SamplingOptions& options,
                   Progress& progress);

// Poses of the mix that are worth choosing from, one by one: no excitations, no calisthenics.
std::vector<float> draw_candidates(const RigSchema& schema, const ControlResponses& responses, const std::string& mix,
                                   std::uint64_t seed, std::size_t poses);

// sample, with a probe that is made when it is needed.
SampleReport sample_probed(RigEvaluator& rig, const SamplingOptions& options,
                           const std::function<const ControlResponses&()>& responses,
                           const std::filesystem::path& directory, Progress& progress);

}  // namespace fb::bake
