// Reports on training poses: what they do not cover, and how the error falls with their number. Nothing is chosen by
// them.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "bake/measure/errors.h"
#include "bake/recipe/bake_options.h"
#include "bake/rig/rig_evaluator.h"
#include "base/progress.h"
#include "figures/training_figures.h"
#include "model/packed_model.h"

namespace fb::bake {

struct LearningCurve {
  struct Point {
    std::size_t poses = 0;
    Errors errors;
  };
  std::vector<Point> points;  // by rising number of poses
  // mse = factor * poses^-exponent, a straight line through the logarithms of the last three points by least squares.
  double exponent = 0, factor = 0;
  double deviation = 0;  // root mean square distance of those points from the line, as a ratio of errors less 1

  double mse_at(double poses) const;
};

// Trains on some of the poses (indices into the training set, ascending) and measures on independent ones.
using TrainAndMeasure = std::function<Errors(std::span<const std::uint32_t> poses)>;

// Runs with 1/8, 1/4, 1/2 and all of `poses` training poses: nested random subsets, drawn by the seed. Fails with
// invalid_argument on fewer than 16 poses.
LearningCurve learning_curve(std::size_t poses, std::uint64_t seed, const TrainAndMeasure& train_and_measure,
                             Progress& progress);

// What twice the poses would bring: a sentence.
std::string outlook_text(const LearningCurve& curve);

// The learning curve of the recipe of the options, measured on at most 1,000 of the independent poses, to
// BakeStats::learning, and its outlook to the notes. `whole` is the model baked on all training poses. None without
// independent poses, on fewer than 16 training poses, and, with a note, for a recipe that evaluates the rig within a
// budget.
void measure_learning_curve(const PoseSet& training, const PoseSet& independent, const PackedModel& whole,
                            RigEvaluator* rig, const BakeOptions& options, BakeStats& stats, Progress& progress);

// coverage_text of what the training poses cover of the independent ones; "" if either set is empty.
std::string coverage_report(const PoseSet& training, const PoseSet& independent, const Parallel& parallel);

}  // namespace fb::bake
