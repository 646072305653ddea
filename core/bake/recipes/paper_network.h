// The paper's architecture, shared by the recipes that differ in what they feed it and how they train it.
#pragma once

#include <cstdint>
#include <vector>

#include "bake/basis/pca.h"
#include "bake/recipes/recipe.h"
#include "bake/train/trainer.h"

namespace fb {

// What the paper's PCA holds of the variance, and how we read its training: ReLU, Adam 1e-3 along a cosine, batches of
// 256.
inline constexpr double paper_variance = 0.999;
TrainingPlan paper_plan();

// One identity feature a control, in units of its reach, in the order of the controls.
std::vector<Feature> identity_features(const RigSchema& schema);

// The values of identity_features in poses (poses x controls): poses x controls.
std::vector<float> identity_values(std::vector<float> controls, const RigSchema& schema);

// principal_components, or those an earlier, interrupted bake of the same poses and fraction left in the work folder.
PrincipalComponents kept_components(const PoseRows& rows, const std::vector<float>& controls, double fraction,
                                    const BakeOptions& options, Progress& progress);

// Eight hidden layers of 256 with additive skips and a linear layer to the coefficients, trained as `plan` says; its
// widths, seed, threads and checkpoint, and epochs where the options give them, are filled in here. `shapes` are the
// fixed blendshapes, one a coefficient: coefficients x 3 x vertices.
Learnt paper_network(const PoseSet& poses, const std::vector<float>& coefficients, const std::vector<float>& shapes,
                     TrainingPlan plan, const BakeOptions& options, Progress& progress);

}  // namespace fb
