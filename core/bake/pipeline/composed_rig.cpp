#include "bake/pipeline/composed_rig.h"

#include "bake/analysis/live/compose_joints.h"
#include "bake/analysis/rig_analysis.h"
#include "bake/rig/changed_rig.h"
#include "bake/rig/composed_source.h"

namespace fb::bake {

ComposedRig compose_rig(Source& rig, const BakeOptions& options, Progress& progress) {
  ComposedRig composed;
  if (!rig.live() || rig.rest().driven.empty() || !pays_to_analyse(rig.schema(), options.rig_budget)) return composed;
  RigEvaluator evaluator(rig, options.parallel, options.work / "joints.evaluations");
  evaluator.set_cache_limit({options.cache_bytes, options.rig_budget > 0});
  check_rig_unchanged(evaluator, options.seed, options.work, progress);
  const EvaluationBudget budget(evaluator, options.rig_budget);
  const PurposeScope purpose(evaluator, EvaluationPurpose::analysis);
  try {
    std::vector<JointComposition> compositions =
        compose_joints(evaluator, AnalysisOptions{}.corrective_tolerance, progress);
    if (!compositions.empty()) composed.source = std::make_unique<ComposedSource>(rig, std::move(compositions));
  } catch (const Error& error) {
    if (!options.skip_failing || !is_of_pose(error)) throw;
    progress.note(format("in which order controls turn joints is not looked for: %s", error.what()));
  }
  composed.counts = evaluator.counts();
  composed.asked = evaluator.requested();
  composed.evaluated = evaluator.evaluated();
  return composed;
}

}  // namespace fb::bake
