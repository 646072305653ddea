// Statistics of a bake, for reports. What does not apply to a recipe stays empty, and reports leave it out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "bake/train/trainer.h"

namespace fb::bake {

// One network and the part of the face it moves.
struct RegionStats {
  std::string name;
  std::size_t vertices = 0, inputs = 0, coefficients = 0, parameters = 0;
  double energy = 0;  // share of the squared residual that all networks learn; shares sum to 1
  // Error on validation poses after training: squared coefficient error over squared coefficients; 0: not measured.
  double validation = 0;
  std::vector<EpochLoss> epochs;  // training curve
  std::uint32_t restarts = 0;     // after the loss became NaN
};

// A point of the learning curve: the error with this number of training poses.
struct LearningPoint {
  std::size_t poses = 0;
  double mse = 0, max = 0;  // on independent poses, over D^2 and D
};

struct BakeStats {
  std::vector<std::string> notes;       // sentences, such as what the analysis found
  std::size_t bones = 0;                // of the skeleton of a baseline that has one
  std::uint64_t rig_calls = 0;          // poses of a live rig evaluated besides the recorded ones
  std::vector<RegionStats> regions;     // the first of the model's regions, in order
  std::vector<LearningPoint> learning;  // by ascending poses
  std::string coverage;                 // what training poses do not cover: sentences and Markdown tables
};

}  // namespace fb::bake
