// What engines do with shapes: few joints, moved by matrices that are linear in the weights of shapes, and linear blend
// skinning, after Kavan, Doublestein, Prazak, Cioffi, Roble, "Compressed Skinning for Facial Blendshapes", SIGGRAPH
// 2024: the matrix of a joint is the identity plus the sum over shapes of weight times a 3 x 4 matrix, a tenth of
// which is not 0.
//
// Here: the shapes are those of the rig's curves and correctives, the strongest; 40 bones, up to four a vertex.
// Transforms and skin weights are fitted in turn by least squares, in place of their descent on both at once.
#include <algorithm>
#include <numeric>

#include "bake/analysis/rig_analysis.h"
#include "bake/baselines/baselines.h"
#include "bake/baselines/model_residual.h"
#include "bake/baselines/skinning/bone_weights.h"
#include "bake/baselines/skinning/linear_transforms.h"
#include "bake/face/network_inputs.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::uint32_t bones = 40, rounds = 4;
constexpr double share = 0.1;             // of the matrices that are not 0
constexpr std::size_t most_shapes = 800;  // the strongest

// The shapes of the rig that move most, in the order of its features.
void keep_strongest(std::vector<SparseShape>& shapes) {
  if (shapes.size() <= most_shapes) return;
  const auto size = [](const SparseShape& shape) {
    return std::inner_product(shape.offsets.begin(), shape.offsets.end(), shape.offsets.begin(), 0.0);
  };
  std::vector<double> sizes;
  for (const SparseShape& shape : shapes) sizes.push_back(size(shape));
  std::nth_element(sizes.begin(), sizes.begin() + most_shapes, sizes.end(), std::greater<>());
  std::erase_if(shapes, [&](const SparseShape& shape) { return size(shape) <= sizes[most_shapes]; });
}

std::vector<float> dense(std::span<const SparseShape> shapes, std::size_t rows) {
  std::vector<float> all(shapes.size() * rows);
  for (std::size_t s = 0; s < shapes.size(); ++s) add_scaled(shapes[s], 1, std::span(all).subspan(s * rows, rows));
  return all;
}

// Fits the skin's weights to shapes as the bones move them.
void fit_weights(Skeleton& skeleton, const Mesh& rest, std::span<const float> shapes,
                 const std::vector<float>& transforms, const Parallel& parallel) {
  std::vector<float> points(shapes.begin(), shapes.end());
  for (std::size_t i = 0; i < points.size(); ++i) points[i] += rest.points[i % rest.points.size()];
  const PoseSample sample(rest, points);
  const BoneMotion motion(skeleton, rest, sample, transforms, parallel);
  solve_weights(skeleton, motion, SurfaceGraph(rest, {}), 0, parallel);
}

}  // namespace

RecipeResult make_kavan2024(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress) {
  RecipeResult result;
  FaceModel& model = result.model;
  model.schema = poses.source().schema();
  model.rest = poses.source().rest();
  AnalysisOptions analysing;
  analysing.seed = options.seed;
  analysing.rig_budget = options.rig_budget;
  RigAnalysis analysis = rig && pays_to_analyse(model.schema, options.rig_budget)
                             ? analyse_rig(*rig, analysing, progress)
                             : analyse_poses(poses, analysing, options.parallel, progress);
  std::vector<SparseShape>& found = analysis.base.shapes;
  const std::size_t all = found.size();
  keep_strongest(found);
  std::ranges::sort(found, {}, &SparseShape::feature);
  const std::vector<float> shapes = dense(found, model.rest.points.size());
  Skeleton skeleton = extract_skeleton(poses, {.bones = bones}, options.parallel, progress);
  std::vector<float> transforms;
  progress.begin(Phase::analysis, "fitting joints to shapes", rounds);
  for (std::uint32_t round = 0; round < rounds; ++round) {
    if (round > 0) fit_weights(skeleton, model.rest, shapes, transforms, options.parallel);
    transforms = fit_linear_transforms(skeleton, model.rest, shapes, share, options.parallel);
    progress.step(round + 1);
  }
  model.network.features = analysis.base.features;
  std::vector<std::uint32_t> features;
  for (const SparseShape& shape : found) features.push_back(shape.feature);
  model.network.regions = {transform_region(skeleton, std::move(features), transforms)};
  keep_live_features(model.network);
  model.basis = basis_by_bone(skeleton, skinning_shapes(skeleton, model.rest));
  result.packing.output_bits = 16;
  result.packing.coefficient_sizes = rms_coefficients(model, poses, options.parallel);
  result.stats.rig_calls = analysis.rig_calls;
  result.stats.bones = skeleton.bone_count();
  result.stats.notes = {
      format("%zu of %zu shapes of the rig move %zu joints", found.size(), all, skeleton.bone_count())};
  return result;
}

}  // namespace fb::bake
