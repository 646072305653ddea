#include "bake/face/face_recipe.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "bake/compress/fit_target.h"
#include "bake/face/assemble_basis.h"
#include "bake/face/curve_tables.h"
#include "bake/face/finish_face.h"
#include "bake/face/network_inputs.h"
#include "bake/face/train_region_networks.h"
#include "bake/linalg/gemm.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t pruning_poses = 1000;     // on which correctives are weighed against their bytes
constexpr double max_compression_error = 2e-4;  // over D: what is exact beside much that cannot be learned stays so
constexpr double min_additive_error = 5e-6;     // FaceRecipe::min_compression_error of an additive face, at most

// The uncentred covariance of the coefficients: outputs x outputs, the mean over poses of products of two coefficients.
std::vector<float> coefficient_covariance(const LocalBasis& basis, std::size_t poses) {
  const std::size_t n = basis.count;
  std::vector<float> covariance(n * n);
  gemm(Op::plain, Op::transposed, n, n, poses, basis.coefficients.data(), n, basis.coefficients.data(), n, 0,
       covariance.data(), n);
  for (float& value : covariance) value /= static_cast<float>(poses);
  return covariance;
}

// Where the blendshapes leave no region, correctives may take half of the bytes that a pose reads: a pruned one would
// need a network, which costs more. On Aura, compact with seed 4 pruned 28 of 151 for 150 kB: 656 kB and a worst vertex
// of 4.5e-3 of the diagonal (bench_worst_poses), instead of 433 kB and 2.2e-3 with all of them.
double most_corrective_bytes(const FaceRecipe& recipe, const std::vector<FaceRegion>& regions, std::size_t vertices) {
  return recipe.bytes_for(
      regions.empty() ? std::max(recipe.corrective_bytes, recipe.max_bytes_read / 2) : recipe.corrective_bytes,
      vertices);
}

// Has networks learn those numbers of driven joints alone of which blendshapes and correctives leave more than a share.
// A network that moves a joint moves all that follows it, also where few controls act: on MakeHuman, whose joints leave
// at most a tenth where they leave much, networks made the worst vertex of expressions of few angles 40 times worse
// (bench_sparse_poses) and the mse of random poses by no more than a third better.
void leave_joints_to_correctives(RigAnalysis& analysis, const Mesh& rest, std::size_t controls) {
  constexpr double most_left = 0.25;
  const std::size_t vertices = rest.vertex_count();
  for (std::size_t v = rest.first_joint_coordinate() / 3; v < vertices; ++v) {
    double left = 0, moved = 0;
    for (std::size_t at = v; at < controls * vertices; at += vertices) {
      left += double(analysis.residual_motion[at]) * analysis.residual_motion[at];
      moved += double(analysis.motion[at]) * analysis.motion[at];
    }
    if (left > most_left * most_left * moved) continue;
    for (std::size_t at = v; at < controls * vertices; at += vertices) analysis.residual_motion[at] = 0;
  }
}

// The structure of a face: sparse blendshapes, and the regions of their residual with a basis each.
struct Decomposition {
  RigAnalysis analysis;
  bool live = false;  // the analysis is of the rig, not of recorded poses
  std::vector<FaceRegion> regions;
  std::vector<LocalBasis> bases;
};

// What the rig shows; nothing where it cannot evaluate a pose and such poses are skipped.
std::optional<RigAnalysis> analyse_live(RigEvaluator& rig, const AnalysisOptions& analysis, bool skip_failing,
                                        Progress& progress) {
  const PurposeScope purpose(rig, EvaluationPurpose::analysis);
  try {
    return analyse_rig(rig, analysis, progress);
  } catch (const Error& error) {
    if (!skip_failing || !is_of_pose(error)) throw;
    progress.note(
        format("the rig is not analysed, and blendshapes are fitted to the training poses instead: %s", error.what()));
    return std::nullopt;
  }
}

Decomposition decompose(const FaceRecipe& recipe, const TrainingPoses& training, RigEvaluator* rig,
                        const BakeOptions& options, Progress& progress) {
  Decomposition face;
  const PoseSet &poses = training.all, fitted = training.fitted();
  AnalysisOptions analysis = recipe.analysis;
  analysis.seed = options.seed;
  analysis.rig_budget = options.rig_budget;
  std::optional<RigAnalysis> live;
  if (rig) live = analyse_live(*rig, analysis, options.skip_failing, progress);
  face.live = live.has_value();
  face.analysis = live ? std::move(*live) : analyse_poses(fitted, analysis, options.parallel, progress);
  const Mesh& rest = poses.source().rest();
  const RigSchema& schema = poses.source().schema();
  leave_joints_to_correctives(face.analysis, rest, schema.control_count());
  RegionOptions region_options = recipe.regions;
  region_options.seed = options.seed;
  face.regions = find_regions(rest, schema, face.analysis.residual_motion, region_options);
  const std::size_t dropped =
      prune_correctives(face.analysis, schema, without_shots(poses).subsampled(pruning_poses).controls(), rest,
                        most_corrective_bytes(recipe, face.regions, rest.vertex_count()));
  if (dropped > 0) {
    progress.note(format("%zu of %zu correctives are left to the networks", dropped, face.analysis.correctives.size()));
    face.regions = find_regions(rest, schema, face.analysis.residual_motion, region_options);
  }
  const auto base = std::make_shared<BlockedBlendshapes>(face.analysis.base, rest.vertex_count());
  face.bases = local_bases(Residual(fitted, base), Residual(poses, base), face.regions, recipe.basis, options.parallel,
                           progress);
  // Regions without residual need no network.
  for (std::size_t r = face.regions.size(); r-- > 0;)
    if (face.bases[r].count == 0 || face.regions[r].controls.empty()) {
      face.regions.erase(face.regions.begin() + static_cast<std::ptrdiff_t>(r));
      face.bases.erase(face.bases.begin() + static_cast<std::ptrdiff_t>(r));
    }
  return face;
}

std::vector<std::string> summary_notes(const Decomposition& face, const RegionNetworks& networks) {
  std::size_t values = 0;
  for (const SparseShape& shape : face.analysis.base.shapes) values += shape.offsets.size();
  std::vector<std::string> notes = {
      format("the blendshapes are %zu shapes with %zu values; %u controls are linear, %zu correctives were found; "
             "between knots the curves are off by %.1e of the diagonal at most",
             face.analysis.base.shapes.size(), values, face.analysis.linear_controls, face.analysis.correctives.size(),
             face.analysis.curve_error)};
  if (face.regions.empty())
    notes.push_back("the blendshapes leave no residual: there are no networks");
  else
    notes.push_back(format("%zu networks leave %.3g %% of the squared residual of the poses held back",
                           face.regions.size(), 100 * networks.share_left));
  if (networks.region_poses > 0)
    notes.push_back(format("besides all poses, networks are trained on %zu that the controls of one region move",
                           networks.region_poses));
  return notes;
}

}  // namespace

double FaceRecipe::bytes_for(double bytes, std::size_t vertices) const {
  return bytes * std::max(1.0, double(vertices) / double(full_size_vertices));
}

TrainedFace train_face(const FaceRecipe& recipe, const TrainingPoses& training, RigEvaluator* rig,
                       const BakeOptions& options, Progress& progress) {
  const PoseSet& poses = training.all;
  if (rig && !pays_to_analyse(rig->schema(), options.rig_budget)) rig = nullptr;
  Decomposition parts = decompose(recipe, training, rig, options, progress);
  RegionInputs inputs = region_inputs(parts.analysis, poses.source().schema(), parts.regions, parts.live);
  if (!parts.live)
    for (std::size_t r = 0; r < parts.regions.size(); ++r)
      inputs.scales.push_back(input_scales(inputs.features, inputs.of_region[r], parts.regions[r]));
  TrainedFace face;
  face.additive = parts.regions.empty() && parts.analysis.correctives.empty();
  face.model.schema = poses.source().schema();
  face.model.rest = poses.source().rest();
  face.model.coarsest_levels = options.coarsest_levels;
  face.model.network.features = inputs.features;
  RegionNetworks networks = train_region_networks(recipe, parts.regions, parts.bases, inputs, training,
                                                  parts.analysis.base, parts.live ? rig : nullptr, options, progress);
  std::vector<CurveTable> tables = take_curve_tables(parts.analysis.base, poses, recipe.analysis.curve_tolerance / 2);
  for (const SparseShape& shape : parts.analysis.base.shapes) face.model.network.direct.push_back(shape.feature);
  face.stats.notes = summary_notes(parts, networks);
  face.model.network.regions = std::move(networks.regions);
  for (CurveTable& table : tables) {
    face.model.network.regions.push_back(std::move(table.network));
    parts.regions.push_back(std::move(table.region));
    parts.bases.push_back(std::move(table.basis));
  }
  keep_live_features(face.model.network);
  face.model.basis = assemble_basis(face.model.rest.vertex_count(), parts.analysis.base, parts.regions, parts.bases);
  for (const LocalBasis& basis : parts.bases) face.covariance.push_back(coefficient_covariance(basis, poses.size()));
  face.rms_error = networks.rms_error;
  face.stats.regions = std::move(networks.stats);
  face.stats.rig_calls = parts.analysis.rig_calls;
  for (const std::string& note : face.stats.notes) progress.note(note);
  return face;
}

RecipeResult make_face(const FaceRecipe& recipe, const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options,
                       Progress& progress) {
  const TrainingPoses training(poses, options.seed);
  TrainedFace face = train_face(recipe, training, rig, options, progress);
  const double min_error =
      face.additive ? std::min(recipe.min_compression_error, min_additive_error) : recipe.min_compression_error;
  const Precision precision{
      std::clamp(recipe.compression_error_share * face.rms_error, min_error, max_compression_error),
      recipe.weight_bits};
  BlockwisePcaOptions localize;
  localize.threshold = precision.scale;
  PackOptions packing = precision.pack();
  packing.normal_weight = options.normal_weight;
  // Without networks, sparse shapes alone need the fewest bytes for an error with fewer dropped columns.
  if (face.model.network.regions.empty()) packing.drop *= 0.5;
  const std::size_t vertices = face.model.rest.vertex_count();
  if (vertices > recipe.full_size_vertices && recipe.max_bytes_read > 0 && options.max_bytes == 0 &&
      options.max_error <= 0) {
    face.stats.notes.push_back(
        format("poses may read %.3g MB: the %.3g MB of %zu vertices, in proportion to the %zu of this face",
               recipe.bytes_for(recipe.max_bytes_read, vertices) / 1e6, recipe.max_bytes_read / 1e6,
               recipe.full_size_vertices, vertices));
    progress.note(face.stats.notes.back());
  }
  RecipeResult result = finish_face(face.model, face.covariance, localize, packing, training, options, progress,
                                    recipe.bytes_for(recipe.max_bytes_read, vertices));
  face.stats.notes.insert(face.stats.notes.end(), result.stats.notes.begin(), result.stats.notes.end());
  result.stats = std::move(face.stats);
  result.held_back = training.split.validation;
  return result;
}

}  // namespace fb::bake
