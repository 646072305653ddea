#include "bake/pipeline/composed_rig.h"

#include "bake/analysis/live/compose_joints.h"
#include "bake/analysis/rig_analysis.h"
#include "bake/rig/composed_source.h"

namespace fb::bake {

void compose_rig(RigEvaluator& rig, const BakeOptions& options, Progress& progress) {
  if (!rig.live() || rig.rest().driven.empty() || !pays_to_analyse(rig.schema(), options.rig_budget)) return;
  const EvaluationBudget budget(rig, options.rig_budget);
  const PurposeScope purpose(rig, EvaluationPurpose::joints);
  try {
    std::vector<JointComposition> compositions = compose_joints(rig, AnalysisOptions{}.corrective_tolerance, progress);
    if (!compositions.empty()) rig.convert<ComposedSource>(std::move(compositions));
  } catch (const Error& error) {
    if (!options.skip_failing || !is_of_pose(error)) throw;
    progress.note(format("in which order controls turn joints is not looked for: %s", error.what()));
  }
}

}  // namespace fb::bake
