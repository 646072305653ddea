// Plans of poses from the responses of a rig, and the steps of sampling that can share one set of responses.
#pragma once

#include <functional>

#include "bake/sampling/control_responses.h"
#include "bake/sampling/sampling.h"

namespace fb::bake {

// Fails on options that allow for no plan. Evaluates nothing.
void check_options(const Source& rig, const SamplingOptions& options);

// make_plan where the responses of the rig are known.
PosePlan make_plan(const Source& rig, const ControlResponses& responses, const SamplingOptions& options,
                   Progress& progress);

// Poses of the mix that active sampling selects from: no excitations, no calisthenics.
std::vector<float> draw_candidates(const RigSchema& schema, const ControlResponses& responses,
                                   const SamplingOptions& options, std::uint64_t seed, std::size_t poses);

// sample, with responses that are evaluated where they are first needed.
SampleReport sample_with_responses(RigEvaluator& rig, const SamplingOptions& options,
                                   const std::function<const ControlResponses&()>& responses,
                                   const std::filesystem::path& directory, Progress& progress);

}  // namespace fb::bake
