// The paper's network given every chance: the same eight layers of 256 with the same skips, and whatever the paper
// leaves open chosen well. The honest baseline for everything else.
#include "bake/baselines/baselines.h"
#include "bake/baselines/paper_network.h"
#include "bake/sampling/validation_split.h"

namespace fb::bake {
namespace {

constexpr double variance_held = 0.9999;
constexpr double pose_visits = 4e6;

}  // namespace

RecipeResult make_paper_tuned(const PoseSet& poses, RigEvaluator*, const BakeOptions& options, Progress& progress) {
  const PrincipalComponents pca =
      kept_components(Displacements(poses), poses.controls(), variance_held, options, progress);
  const ValidationSplit split = validation_split(poses, validation_share_of_poses, options.seed);
  return paper_network(poses, pca.coefficients, pca.components, tuned_plan(poses.size(), pose_visits, options),
                       split.validation, options, progress);
}

}  // namespace fb::bake
