// The paper's network as we read it: controls -> 8 x 256 ReLU with additive skips -> linear K -> fixed blendshapes that
// hold 99.9 % of the variance (Radzihovsky, de Goes, Meyer, SIGGRAPH 2020 Talks).
#include "bake/baselines/baselines.h"
#include "bake/baselines/paper_network.h"

namespace fb::bake {

RecipeResult make_paper(const PoseSet& poses, RigEvaluator*, const BakeOptions& options, Progress& progress) {
  const PrincipalComponents pca =
      kept_components(Displacements(poses), poses.controls(), paper_variance, options, progress);
  return paper_network(poses, pca.coefficients, pca.components, paper_plan(), {}, options, progress);
}

}  // namespace fb::bake
