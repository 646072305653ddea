#include <algorithm>
#include <optional>

#include "bake/analysis/blendshape_parts.h"
#include "bake/analysis/live/corrective_search.h"
#include "bake/analysis/live/difficult_curves.h"
#include "bake/analysis/live/excitation_curves.h"
#include "bake/analysis/live/finite_differences.h"
#include "bake/analysis/live/missed_correctives.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// Rig calls spent on missed correctives at most: a share of those before, but no fewer than least_missed_calls.
constexpr std::uint64_t missed_share = 10, least_missed_calls = 8192;

}  // namespace

RigAnalysis analyse_rig(RigEvaluator& rig, const AnalysisOptions& options, Progress& progress) {
  if (!rig.live())
    fail(Status::invalid_argument, "\"%s\" is a recording: only a live rig can be analysed by evaluating it",
         rig.schema().name.c_str());
  const EvaluationBudget budget(rig, options.rig_budget);
  RigAnalysis analysis;
  std::vector<ControlCurve> curves = fit_excitations(rig, options, analysis.motion, progress);
  DenseDifferences dense = evaluate_differences(rig, options.seed, progress);
  const std::vector<float> dense_motion = difference_motion(dense, {}, Statistic::largest, rig);
  for (std::size_t i = 0; i < dense_motion.size(); ++i)
    analysis.motion[i] = std::max(analysis.motion[i], dense_motion[i]);
  std::vector<double> errors = validate_curves(rig, curves, options.seed, progress);
  refit_difficult_curves(rig, options, curves, errors, progress);
  analysis.curve_error = *std::max_element(errors.begin(), errors.end());
  std::vector<const SparseBlendshapes*> parts;
  for (const ControlCurve& curve : curves) {
    parts.push_back(&curve.part);
    analysis.linear_controls += curve.part.shapes.size() == 1 && curve.steps.empty();
  }
  append(analysis.base, parts);
  std::optional<CorrectiveSearch> correctives(std::in_place, rig, options, curves, dense, analysis.base, progress);
  if (options.max_pairs > 0) correctives->find(2, options.max_pairs);
  if (add_joint_steps(rig, options, *correctives, curves, progress)) {
    analysis.base = {};
    append(analysis.base, parts);
    correctives.reset();
    evaluate_displacements(rig, dense, progress);
    correctives.emplace(rig, options, curves, dense, analysis.base, progress);
    correctives->find(2, options.max_pairs);
  }
  if (options.max_triples > 0) {
    correctives->find(3, options.max_triples);
    correctives->find(4, options.max_triples / 4);
  }
  if (options.max_pairs > 0)
    add_missed_correctives(rig, options, analysis.motion, analysis.base,
                           std::max(budget.requested() / missed_share, least_missed_calls), *correctives, progress);
  analysis.correctives = correctives->prune();
  analysis.residual_motion = difference_motion(dense, analysis.base, Statistic::root_mean_square, rig);
  analysis.rig_calls = budget.requested();
  return analysis;
}

}  // namespace fb::bake
