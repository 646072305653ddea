// What paper-tuned and bailey2018 share: a well-tuned training, and the statistics of what was trained.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "bake/recipe/recipe.h"
#include "bake/train/trainer.h"

namespace fb::bake {

// The best training we know for tanh networks: scaled outputs, warmup-stable-decay at a high rate, small batches and
// quantisation-aware last epochs. `facebaker compare SOURCE --methods paper,paper-tuned` prints what it gains over the
// paper's. Epochs: as many as make `pose_visits` in total, 40 to 400, or those of the options.
TrainingPlan tuned_plan(std::size_t poses, double pose_visits, const BakeOptions& options);
// The share of the poses that then is the validation set.
inline constexpr double tuned_validation_share = 0.04;

// The statistics of a network that moves `vertices` vertices; its energy is absolute until normalise_energy.
RegionStats region_stats(const std::string& name, std::size_t vertices, const TrainingSet& set,
                         const TrainedLayers& trained);
// Divides the energies by their sum.
void normalise_energy(std::vector<RegionStats>& regions);

}  // namespace fb::bake
