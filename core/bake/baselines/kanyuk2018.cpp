// Skinning with pose-space correctives, after Kanyuk, Coleman, Laird, "Mobilizing Mocap, Motion Blending, and Mayhem",
// SIGGRAPH 2018 Talks, as far as its two pages say: a skeleton is extracted from the poses, weights of linear blend
// skinning are solved for with a smoothing term, and the residual is corrected by shapes that controls drive through a
// sparse interpolant.
//
// Here: 32 bones, up to four a vertex. Each control's ramp moves the bones as fits the shape at its limit best; the
// transforms of several controls add up. One corrective a ramp makes its limit exact; up to 256 more are driven by two
// controls or by the middle of one.
#include <numeric>

#include "bake/baselines/baselines.h"
#include "bake/baselines/model_residual.h"
#include "bake/baselines/pose_correctives.h"
#include "bake/baselines/ramp_blendshapes.h"
#include "bake/baselines/skinning/bone_fitter.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr double corrective_threshold = 1e-5;  // over the diagonal: smaller offsets of correctives are dropped
constexpr std::uint32_t shape_sweeps = 6;      // of fitting bones to a shape

// One linear layer without bias from the ramps to the transform parameters of all bones.
Region skeleton_region(const Skeleton& skeleton, const Mesh& rest, const std::vector<float>& shapes, std::size_t ramps,
                       const Parallel& parallel) {
  const BoneFitter fitter(skeleton, rest);
  const std::size_t rows = rest.points.size(), parameters = skeleton.parameter_count();
  std::vector<float> transforms(ramps * parameters);
  parallel_for(parallel, ramps, [&](std::size_t r, std::size_t) {
    fitter.fit(std::span(shapes).subspan(r * rows, rows), std::span(transforms).subspan(r * parameters, parameters),
               false, shape_sweeps);
  });
  std::vector<std::uint32_t> features(ramps);
  std::iota(features.begin(), features.end(), 0u);
  return transform_region(skeleton, std::move(features), transforms);
}

}  // namespace

RecipeResult make_kanyuk2018(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress) {
  RecipeResult result;
  FaceModel& model = result.model;
  model.schema = poses.source().schema();
  model.rest = poses.source().rest();
  const std::vector<Feature> ramps = ramp_features(model.schema);
  std::vector<float> correctives = ramp_shapes(poses, rig, ramps, progress);
  const Skeleton skeleton = extract_skeleton(poses, {}, options.parallel, progress);
  model.network.features = ramps;
  model.network.regions = {skeleton_region(skeleton, model.rest, correctives, ramps.size(), options.parallel)};

  // The correctives of the ramps: their shapes minus the skinning.
  const std::size_t rows = model.rest.points.size(), parameters = skeleton.parameter_count();
  for (std::size_t r = 0; r < ramps.size(); ++r) {
    std::vector<float> transforms(parameters);
    for (std::size_t n = 0; n < parameters; ++n)
      transforms[n] = model.network.regions[0].layers[0].weights[n * ramps.size() + r];
    add_skinned(skeleton, model.rest, transforms, -1, std::span(correctives).subspan(r * rows, rows));
  }

  // Columns of the basis: correctives, then bones.
  const std::vector<float> bones = skinning_shapes(skeleton, model.rest);
  const auto set_correctives = [&] {
    drop_below(correctives, model.rest, corrective_threshold);
    model.network.direct.resize(model.network.features.size());
    std::iota(model.network.direct.begin(), model.network.direct.end(), 0u);
    std::vector<float> all = correctives;
    all.insert(all.end(), bones.begin(), bones.end());
    model.basis = basis_by_bone(skeleton, all);
  };
  set_correctives();
  const PoseCorrectives more = find_correctives(ModelResidual(poses, model), ramps, {}, options.parallel, progress);
  model.network.features.insert(model.network.features.end(), more.features.begin(), more.features.end());
  correctives.insert(correctives.end(), more.shapes.begin(), more.shapes.end());
  set_correctives();
  result.packing.output_bits = 16;
  result.packing.coefficient_sizes = rms_coefficients(model, poses, options.parallel);
  result.stats.notes = {
      format("%zu correctives at the limits of single controls, %zu of two controls or of the middle of one",
             ramps.size(), more.features.size())};
  result.stats.bones = skeleton.bone_count();
  return result;
}

}  // namespace fb::bake
