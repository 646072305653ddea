// The paper's other representation, which it says gave similar results: deformation gradients in place of translations.
// The same network learns the components that hold 99.9 % of the gradients' variance; the archive holds what each of
// them rebuilds, so posing costs no Poisson solve.
#include "bake/baselines/baselines.h"
#include "bake/baselines/gradient_map.h"
#include "bake/baselines/paper_network.h"

namespace fb::bake {

RecipeResult make_paper_gradients(const PoseSet& poses, RigEvaluator*, const BakeOptions& options, Progress& progress) {
  const GradientMap map(poses.source().rest());
  const PrincipalComponents pca =
      kept_components(GradientRows(poses, map), poses.controls(), paper_variance, options, progress);
  std::vector<float> shapes(pca.components.size());
  parallel_for(options.parallel, pca.count, [&](std::size_t k, std::size_t) {
    map.to_displacements(std::span(pca.components).subspan(k * pca.rows, pca.rows),
                         std::span(shapes).subspan(k * pca.rows, pca.rows));
  });
  return paper_network(poses, pca.coefficients, shapes, paper_plan(), {}, options, progress);
}

}  // namespace fb::bake
