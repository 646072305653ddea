#include "bake/pipeline/ensemble.h"

#include <algorithm>
#include <array>
#include <memory>
#include <numeric>

#include "bake/analysis/rig_analysis.h"
#include "bake/face/network_inputs.h"
#include "bake/recipe/recipe.h"
#include "bake/regions/local_basis.h"
#include "bake/regions/residual.h"
#include "bake/train/trainer.h"
#include "base/random_streams.h"

namespace fb::bake {
namespace {

constexpr std::uint32_t width = 128, training_steps = 4000;
constexpr std::size_t max_components = 64;

TrainingSet training_set(std::size_t poses, std::size_t controls, std::size_t outputs, std::span<const float> inputs,
                         std::span<const float> targets) {
  TrainingSet set;
  set.poses = poses;
  set.inputs = controls;
  set.outputs = outputs;
  set.features = inputs;
  set.targets = targets;
  return set;
}

}  // namespace

TrainEnsemble network_ensemble(std::uint64_t seed, const Parallel& parallel, Progress& progress) {
  return [=, &progress](Source& recorded, std::uint32_t round) -> EnsembleVariance {
    const PoseSet poses = training_poses(recorded, Use::variant);
    const RigSchema schema = recorded.schema();
    AnalysisOptions curves;
    curves.max_pairs = curves.max_triples = 0;
    const RigAnalysis analysis = analyse_poses(poses, curves, parallel, progress);
    FaceRegion face{"face", {}, {}, {}, 1};
    face.vertices.resize(recorded.rest().vertex_count());
    std::iota(face.vertices.begin(), face.vertices.end(), 0u);
    face.weights.assign(face.vertices.size(), 1.0f);
    const Residual residual(poses, analysis.base);
    LocalBasisOptions options;
    options.max_components = max_components;
    const LocalBasis basis = local_bases(residual, {face}, options, parallel, progress).front();
    const std::size_t outputs = basis.count;
    const bool no_residual = std::ranges::all_of(basis.coefficients, [](float c) { return c == 0; });
    if (outputs == 0 || no_residual)
      return [](std::span<const float>, std::size_t count) { return std::vector<float>(count); };

    const std::vector<float> inputs = identity_values(poses.controls(), schema);
    std::array<std::vector<DenseLayer>, 2> networks;
    for (std::size_t n = 0; n < networks.size(); ++n) {
      TrainingPlan plan;
      plan.widths = {width, width};
      plan.activation = Activation::silu;
      plan.schedule = Schedule::warmup_stable_decay;
      plan.learning_rate = 4e-3f;
      plan.output_scaling = 0.75f;
      plan.epochs = std::max<std::uint32_t>(1, training_steps * plan.batch / static_cast<std::uint32_t>(poses.size()));
      plan.seed = seed_of(seed, Stream::ensemble_networks, networks.size() * round + n);
      plan.parallel = parallel;
      networks[n] =
          train_layers(training_set(poses.size(), schema.control_count(), outputs, inputs, basis.coefficients), plan,
                       progress)
              .layers;
    }
    const double vertices = static_cast<double>(recorded.rest().vertex_count());
    const double scale = 1 / (recorded.rest().diagonal() * recorded.rest().diagonal() * vertices);
    return [=](std::span<const float> controls, std::size_t count) {
      const std::vector<float> features = identity_values({controls.begin(), controls.end()}, schema);
      const std::vector<float> no_targets(count * outputs);
      const TrainingSet set = training_set(count, schema.control_count(), outputs, features, no_targets);
      const std::vector<float> one = run_layers(networks[0], set, parallel),
                               other = run_layers(networks[1], set, parallel);
      std::vector<float> variances(count);
      for (std::size_t i = 0; i < one.size(); ++i)
        variances[i / outputs] += static_cast<float>(scale) * (one[i] - other[i]) * (one[i] - other[i]);
      return variances;
    };
  };
}

}  // namespace fb::bake
