#include "bake/face/untrained.h"

#include <numeric>

#include "bake/analysis/rig_analysis.h"
#include "bake/compress/fit_target.h"
#include "bake/face/assemble_basis.h"
#include "bake/face/finish_face.h"
#include "bake/face/network_inputs.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// Over the diagonal. With this packing scale, the worst poses that bench_worst_poses finds of Aura are off by 7e-5;
// with 1e-6 by 1.3e-4, in 0.8 of the bytes.
constexpr double tolerance = 2e-5, packing_scale = 5e-7;
constexpr std::uint32_t max_knots = 16;

AnalysisOptions analysis_options(const BakeOptions& options) {
  AnalysisOptions analysis;
  analysis.curve_tolerance = analysis.corrective_tolerance = tolerance;
  analysis.max_knots = max_knots;
  analysis.seed = options.seed;
  analysis.rig_budget = options.rig_budget;
  return analysis;
}

std::string summary(const RigAnalysis& analysis) {
  std::size_t values = 0;
  for (const SparseShape& shape : analysis.base.shapes) values += shape.offsets.size();
  return format(
      "nothing is learned: %zu shapes with %zu values are what the rig does, %u controls are linear, %zu "
      "correctives were found; between knots the curves are off by %.1e of the diagonal at most",
      analysis.base.shapes.size(), values, analysis.linear_controls, analysis.correctives.size(), analysis.curve_error);
}

}  // namespace

RecipeResult make_untrained(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress) {
  if (!rig)
    fail(Status::invalid_argument,
         "\"%s\" is a recording, and recipe \"untrained\" fits nothing to poses: it needs a rig that it can evaluate",
         poses.source().schema().name.c_str());
  const RigAnalysis analysis = [&] {
    const PurposeScope purpose(*rig, EvaluationPurpose::analysis);
    return analyse_rig(*rig, analysis_options(options), progress);
  }();
  FaceModel model;
  model.schema = poses.source().schema();
  model.rest = poses.source().rest();
  model.coarsest_levels = options.coarsest_levels;
  model.network.features = analysis.base.features;
  for (const SparseShape& shape : analysis.base.shapes) model.network.direct.push_back(shape.feature);
  keep_live_features(model.network);
  model.basis = assemble_basis(model.rest.vertex_count(), analysis.base, {}, {});
  PackOptions packing = Precision{packing_scale}.pack();
  packing.normal_weight = options.normal_weight;
  const std::string note = summary(analysis);
  progress.note(note);
  RecipeResult result = finish_face(model, {}, {}, packing, {poses, options.seed}, options, progress);
  result.stats.notes.insert(result.stats.notes.begin(), note);
  result.stats.rig_calls = analysis.rig_calls;
  result.held_back.resize(poses.size());  // all of them: they measure the face
  std::iota(result.held_back.begin(), result.held_back.end(), 0u);
  return result;
}

}  // namespace fb::bake
