// Linear blendshapes: the shape of each control at its limit, one for either side of rest, scaled linearly by the
// control and summed. What a rig exports to an engine as morph targets.
#include <numeric>

#include "bake/baselines/baselines.h"
#include "bake/baselines/ramp_blendshapes.h"
#include "bake/face/finish_face.h"
#include "base/checked.h"

namespace fb::bake {
namespace {

// Over the diagonal: smaller offsets are dropped, and the quantisation error of the basis. Small, as shapes have no
// other error.
constexpr double drop_threshold = 1e-7, packing_tolerance = 1e-6;

}  // namespace

RecipeResult make_linear(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress) {
  RecipeResult result;
  FaceModel& model = result.model;
  model.schema = poses.source().schema();
  model.rest = poses.source().rest();
  model.network.features = ramp_features(model.schema);
  std::vector<float> shapes = ramp_shapes(poses, rig, model.network.features, progress);
  drop_below(shapes, model.rest, drop_threshold);
  model.network.direct.resize(model.network.features.size());
  std::iota(model.network.direct.begin(), model.network.direct.end(), 0u);
  model.basis = make_basis(checked_u32(model.rest.points.size(), "coordinates"),
                           checked_u32(model.network.direct.size(), "blendshapes"), shapes);
  result.packing.basis_tolerance = packing_tolerance;
  model.coarsest_levels = options.coarsest_levels;
  if (has_target(options) || has_levels(options))
    return finish_face(model, {}, {}, result.packing, {poses, options.seed}, options, progress);
  return result;
}

}  // namespace fb::bake
