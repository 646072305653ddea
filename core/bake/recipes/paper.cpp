// The paper's network as we read it: controls -> 8 x 256 ReLU with additive skips -> linear K -> fixed blendshapes that
// hold 99.9 % of the variance; Adam 1e-3 along a cosine, batches of 256 (Radzihovsky, de Goes, Meyer, SIGGRAPH 2020
// Talks).
#include "bake/recipes/paper_network.h"

namespace fb {
namespace {

constexpr double variance_held = 0.999;
constexpr std::uint32_t default_epochs = 150;

}  // namespace

FaceModel make_paper(const PoseSet& poses, Source*, const BakeOptions& options, Progress& progress) {
  const PrincipalComponents pca =
      kept_components(Displacements(poses), poses.controls(), variance_held, options, progress);
  TrainingPlan plan;
  plan.epochs = default_epochs;
  return paper_network(poses, pca.coefficients, pca.components, plan, options, progress);
}

}  // namespace fb
