#include "bake/pipeline/sample_poses.h"

#include <algorithm>

#include "bake/analysis/rig_analysis.h"
#include "bake/dataset/open_source.h"
#include "bake/pipeline/ensemble.h"
#include "bake/recipe/work_folder.h"
#include "bake/sampling/active_sampling.h"
#include "bake/sampling/linear_rig.h"
#include "base/status.h"

namespace fb::bake {

WantedPoses wanted_poses(RigEvaluator& rig, const BakeOptions& options, RigUse use, Progress& progress) {
  constexpr std::uint64_t of_linear = 2000, to_measure = 2000;
  if (use.evaluates && !use.learns && options.poses == 0)
    return {options.rig_budget > 0 ? std::clamp<std::uint64_t>(options.rig_budget / 4, 1, to_measure) : to_measure};
  // A budget has to leave room for the analysis besides.
  const bool ample = options.rig_budget == 0 || options.rig_budget >= 5 * of_linear;
  const bool free = options.poses == 0 && ample && options.examples.empty();
  if (!free || !use.evaluates || !is_linear(rig, options.seed, progress))
    return {poses_or_usual(options.poses, options.rig_budget)};
  progress.note(format("the rig is linear in its controls: %llu poses are sampled, as its shapes need no more",
                       static_cast<unsigned long long>(of_linear)));
  return {of_linear, true};
}

SamplingOptions sampling_options(const RigEvaluator& rig, const BakeOptions& options, SampledSplits splits,
                                 RigUse use) {
  SamplingOptions sampling;
  sampling.poses = poses_or_usual(options.poses, options.rig_budget);
  sampling.seed = options.seed;
  sampling.mix = options.mix;
  sampling.examples = options.examples;
  sampling.skip_failing = options.skip_failing;
  sampling.test_poses = splits == SampledSplits::training_and_test;
  const std::uint64_t third = options.rig_budget / 3;
  sampling.rig_budget = options.rig_budget - (use.evaluates && pays_to_analyse(rig.schema(), third) ? third : 0);
  // A variant does not train on shots: a limited budget is not spent on them.
  if (options.rig_budget > 0 && splits == SampledSplits::training) sampling.shots = options.use == Use::backlot;
  return sampling;
}

OpenedSource sample_poses(RigEvaluator& rig, const BakeOptions& options, SampledSplits splits, RigUse use,
                          Progress& progress) {
  const SamplingOptions sampling = sampling_options(rig, options, splits, use);
  const std::filesystem::path folder = options.work / sampled_poses_name;
  if (samples_actively(options, use))
    sample_actively(rig, sampling, {}, network_ensemble(options.seed, options.parallel, progress), folder, progress);
  else
    sample(rig, sampling, folder, progress);
  return open_source(folder.string());
}

BakeOptions with_budget_left(BakeOptions options, const RigEvaluator& rig, std::size_t recipes) {
  if (options.rig_budget == 0) return options;
  const std::uint64_t left = options.rig_budget - std::min(rig.requested(), options.rig_budget);
  options.rig_budget = std::max<std::uint64_t>(1, left / std::max<std::size_t>(1, recipes));
  return options;
}

}  // namespace fb::bake
