// The paper's architecture, shared by the recipes that differ in what they feed it and how they train it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bake/baselines/pca.h"
#include "bake/recipe/recipe.h"
#include "bake/train/trainer.h"

namespace fb::bake {

// What the paper's PCA holds of the variance, and how we read its training: ReLU, Adam 1e-3 along a cosine, batches of
// 256.
inline constexpr double paper_variance = 0.999;
TrainingPlan paper_plan();

// Training as well as we know for networks of tanh: outputs in units of their own, a higher rate that lingers, smaller
// batches, the last epochs through rounded weights, and as many epochs as make `visits` of poses in all (40 to 400), or
// as the options say.
TrainingPlan tuned_plan(std::size_t poses, double visits, const BakeOptions& options);
// The part of the poses that is then kept back, to keep the best moment by.
inline constexpr double validation_share_of_poses = 0.04;

// What reports tell of a network that moves so many vertices; its energy is not a share yet.
RegionStats stats_of(const std::string& name, std::size_t vertices, const TrainingSet& set,
                     const TrainedLayers& trained);
void share_energy(std::vector<RegionStats>& regions);

// One identity feature a control, in units of its reach, in the order of the controls.
std::vector<Feature> identity_features(const RigSchema& schema);

// The values of identity_features in poses (poses x controls): poses x controls.
std::vector<float> identity_values(std::vector<float> controls, const RigSchema& schema);

// principal_components, or those an earlier, interrupted bake of the same poses and fraction left in the work folder.
PrincipalComponents kept_components(const PoseRows& rows, const std::vector<float>& controls, double fraction,
                                    const BakeOptions& options, Progress& progress);

// Eight hidden layers of 256 with additive skips and a linear layer to the coefficients, trained as `plan` says; its
// widths, seed, threads and checkpoint, and epochs where the options give them, are filled in here. `shapes` are the
// fixed blendshapes, one a coefficient: coefficients x 3 x vertices. `validation`: see TrainingSet.
RecipeResult paper_network(const PoseSet& poses, const std::vector<float>& coefficients,
                           const std::vector<float>& shapes, TrainingPlan plan,
                           std::span<const std::uint32_t> validation, const BakeOptions& options, Progress& progress);

}  // namespace fb::bake
