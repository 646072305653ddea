// What happened while a face was baked, for the reports people look at. Whatever a recipe has nothing to say of stays
// empty, and reports leave it out.
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
  double energy = 0;  // share of what the networks learn; shares sum to 1
  // Lowest error on poses held back, after training: squared coefficient error over squared coefficients; 0: not known.
  double validation = 0;
  std::vector<EpochLoss> epochs;  // the training curve
  std::uint32_t restarts = 0;     // after the loss stopped being a number
};

// A point of the learning curve: what so many poses are good for.
struct LearningPoint {
  std::size_t poses = 0;
  double mse = 0, max = 0;  // on poses held back, over D^2 and D
};

struct StageTime {
  std::string name;
  double seconds = 0;
};

struct BakeStats {
  std::vector<std::string> notes;       // sentences about the bake: what probing found, what was left out
  std::size_t bones = 0;                // of the skeleton, where there is one
  std::uint64_t rig_calls = 0;          // poses asked of a live rig besides the recorded ones
  std::vector<RegionStats> regions;     // in the order of the model's regions
  std::vector<LearningPoint> learning;  // by ascending poses
  std::string coverage;                 // what the training poses do not cover, in words and Markdown tables
  std::vector<StageTime> stages;        // in the order they were done
};

}  // namespace fb::bake
