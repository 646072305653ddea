// Statistics of a bake, for reports. What does not apply to a recipe stays empty, and reports leave it out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "figures/member_list.h"

namespace fb {

// Losses of one epoch: squared coefficient error over squared coefficients.
struct EpochLoss {
  double training = 0;    // mean over the epoch
  double validation = 0;  // on the validation poses, as last measured
};

template <class Visit, MaybeConst<EpochLoss> Struct>
void visit_fields(Visit& visit, Struct& epoch) {
  visit("training", epoch.training);
  visit("validation", epoch.validation);
}

// One network and the part of the face it moves.
struct RegionStats {
  std::string name;
  std::size_t vertices = 0, inputs = 0, coefficients = 0, parameters = 0;
  std::size_t poses = 0;  // that it was trained on and measured on: those of the face, and its own
  double energy = 0;  // share of the squared residual that all networks learn; shares sum to 1
  // Error on validation poses after training: squared coefficient error over squared coefficients; 0: not measured.
  double validation = 0;
  std::vector<EpochLoss> epochs;  // training curve
  std::uint32_t restarts = 0;     // after the loss became NaN
};

template <class Visit, MaybeConst<RegionStats> Struct>
void visit_fields(Visit& visit, Struct& region) {
  visit("name", region.name);
  visit("vertices", region.vertices);
  visit("inputs", region.inputs);
  visit("coefficients", region.coefficients);
  visit("parameters", region.parameters);
  visit("poses", region.poses);
  visit("energy", region.energy);
  visit("validation", region.validation);
  visit("restarts", region.restarts);
  visit("epochs", region.epochs);
}

// A point of the learning curve: the error with this number of training poses.
struct LearningPoint {
  std::size_t poses = 0;
  double mse = 0, max = 0;  // on independent poses, over D^2 and D
};

template <class Visit, MaybeConst<LearningPoint> Struct>
void visit_fields(Visit& visit, Struct& point) {
  visit("poses", point.poses);
  visit("mse", point.mse);
  visit("max", point.max);
}

struct BakeStats {
  std::vector<std::string> notes;       // sentences, such as what the analysis found
  std::size_t bones = 0;                // of the skeleton of a baseline that has one
  std::uint64_t rig_calls = 0;          // poses of a live rig evaluated besides the recorded ones
  std::vector<RegionStats> regions;     // the first of the model's regions, in order
  std::vector<LearningPoint> learning;  // by ascending poses
  std::string coverage;                 // what training poses do not cover: sentences and Markdown tables
};

// Without bones and rig_calls, which documents have elsewhere.
template <class Visit, MaybeConst<BakeStats> Struct>
void visit_fields(Visit& visit, Struct& stats) {
  visit("notes", stats.notes);
  visit("regions", stats.regions);
  visit("learning", stats.learning);
  visit("coverage", stats.coverage);
}

}  // namespace fb
