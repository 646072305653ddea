#include "bake/face/face_recipe.h"

#include <algorithm>
#include <cmath>

#include "bake/analysis/prune_correctives.h"
#include "bake/compress/fit_target.h"
#include "bake/face/assemble_basis.h"
#include "bake/face/finish_face.h"
#include "bake/face/live_features.h"
#include "bake/face/network_inputs.h"
#include "bake/face/train_networks.h"
#include "bake/linalg/gemm.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t typical_poses = 1000;  // that stand for those to come

// outputs x outputs: the mean over poses of the product of two coefficients.
std::vector<float> second_moments(const LocalBasis& basis, std::size_t poses) {
  const std::size_t n = basis.count;
  std::vector<float> moments(n * n);
  gemm(Op::plain, Op::transposed, n, n, poses, basis.coefficients.data(), n, basis.coefficients.data(), n, 0,
       moments.data(), n);
  for (float& moment : moments) moment /= static_cast<float>(poses);
  return moments;
}

struct Parts {
  RigAnalysis analysis;
  std::vector<FaceRegion> regions;
  std::vector<LocalBasis> bases;
};

// What is probed, and what that leaves over, cut into regions with a basis each.
Parts find_parts(const FaceRecipe& recipe, const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options,
                 Progress& progress) {
  Parts parts;
  AnalysisOptions probing = recipe.analysis;
  probing.seed = options.seed;
  probing.rig_budget = options.rig_budget;
  parts.analysis =
      rig ? analyse_rig(*rig, probing, progress) : analyse_poses(poses, probing, options.parallel, progress);
  const Mesh& rest = poses.source().rest();
  const RigSchema& schema = poses.source().schema();
  const std::size_t dropped =
      prune_correctives(parts.analysis, schema, without_shots(poses).subsampled(typical_poses).controls(),
                        rest.diagonal(), recipe.corrective_bytes);
  if (dropped > 0)
    progress.note(format("%zu of %zu combinations of controls are left to the networks", dropped,
                         parts.analysis.correctives.size()));
  RegionOptions cutting = recipe.regions;
  cutting.seed = options.seed;
  parts.regions = find_regions(rest, schema, parts.analysis.residual_motion, cutting);
  const Residual residual(poses, parts.analysis.base);
  parts.bases = local_bases(residual, parts.regions, recipe.basis, options.parallel, progress);
  // A region with nothing left to learn needs no network.
  for (std::size_t r = parts.regions.size(); r-- > 0;)
    if (parts.bases[r].count == 0 || parts.regions[r].controls.empty()) {
      parts.regions.erase(parts.regions.begin() + static_cast<std::ptrdiff_t>(r));
      parts.bases.erase(parts.bases.begin() + static_cast<std::ptrdiff_t>(r));
    }
  return parts;
}

std::vector<std::string> notes_on(const Parts& parts, double rms) {
  std::size_t numbers = 0;
  for (const SparseShape& shape : parts.analysis.base.shapes) numbers += shape.offsets.size();
  std::vector<std::string> notes = {
      format("the base holds %zu shapes of %zu numbers; %u controls are linear, %zu combinations of controls interact; "
             "between knots it is off by %.1e of the diagonal at most",
             parts.analysis.base.shapes.size(), numbers, parts.analysis.linear_controls,
             parts.analysis.correctives.size(), parts.analysis.curve_error)};
  if (parts.regions.empty())
    notes.push_back("the base leaves nothing over: there are no networks");
  else
    notes.push_back(format("%zu networks leave %.1e of the diagonal (root mean square, poses kept back)",
                           parts.regions.size(), rms));
  return notes;
}

}  // namespace

TrainedFace train_face(const FaceRecipe& recipe, const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options,
                       Progress& progress) {
  if (rig && !pays_to_analyse(rig->schema(), options.rig_budget)) rig = nullptr;
  const Parts parts = find_parts(recipe, poses, rig, options, progress);
  const RegionInputs inputs = region_inputs(parts.analysis, poses.source().schema(), parts.regions, rig != nullptr);
  TrainedFace face;
  face.model.schema = poses.source().schema();
  face.model.rest = poses.source().rest();
  face.model.network.features = inputs.features;
  for (const SparseShape& shape : parts.analysis.base.shapes) face.model.network.direct.push_back(shape.feature);
  Networks networks = train_networks(recipe, parts.regions, parts.bases, inputs, poses, options, progress);
  face.model.network.regions = std::move(networks.regions);
  keep_live_features(face.model.network);
  face.model.basis = assemble_basis(face.model.rest.vertex_count(), parts.analysis.base, parts.regions, parts.bases);
  for (const LocalBasis& basis : parts.bases) face.moments.push_back(second_moments(basis, poses.size()));
  face.rms = networks.rms;
  face.adds_up = parts.regions.empty() && parts.analysis.correctives.empty();
  face.stats.regions = std::move(networks.stats);
  face.stats.rig_calls = parts.analysis.rig_calls;
  face.stats.notes = notes_on(parts, networks.rms);
  for (const std::string& note : face.stats.notes) progress.note(note);
  return face;
}

RecipeResult make_face(const FaceRecipe& recipe, const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options,
                       Progress& progress) {
  TrainedFace face = train_face(recipe, poses, rig, options, progress);
  const double finest = face.adds_up ? std::min(recipe.finest, 5e-6) : recipe.finest;
  const Precision precision{std::max(recipe.precision * face.rms, finest), recipe.weight_bits};
  BlockwisePcaOptions localize;
  localize.threshold = precision.scale;
  PackOptions packing = precision.pack();
  // Without networks, whose columns are chosen by how much they move, shapes take fewest bytes for an error where more
  // of them is kept and rounded in larger steps, but nearer to them.
  if (face.model.network.regions.empty()) {
    localize.block_vertices = 100;
    packing.drop *= 0.5;
    packing.step *= 1.31;
    packing.step_lambda = 13;
  }
  RecipeResult result =
      finish_face(face.model, face.moments, localize, packing, poses, options, progress, recipe.touched_bytes);
  result.stats = std::move(face.stats);
  return result;
}

}  // namespace fb::bake
