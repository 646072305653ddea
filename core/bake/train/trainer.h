#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "base/progress.h"
#include "model/network.h"

namespace fb {

// What a region network learns: features of a pose -> coefficients. Row after row, one row a pose; features are 0 at
// rest.
struct TrainingSet {
  std::size_t poses = 0, inputs = 0, outputs = 0;
  std::span<const float> features;  // poses x inputs
  std::span<const float> targets;   // poses x outputs
};

struct TrainingPlan {
  std::vector<std::uint32_t> widths;  // of the hidden layers; a last linear layer to the coefficients follows
  float learning_rate = 1e-3f;        // falls to 0 along a half cosine
  std::uint32_t batch = 256;
  std::uint32_t epochs = 100;
  std::uint64_t seed = 1;
  Parallel parallel;
  std::filesystem::path checkpoint;  // saved twice a minute and gone on from; empty: none
};

struct TrainedLayers {
  std::vector<DenseLayer> layers;
  // Mean over the last epoch of squared coefficient error over squared coefficients; too small if this call went on from
  // the middle of that epoch.
  double loss = 0;
};

// Trains dense layers with ReLU and additive skips (where widths allow) by Adam (Kingma, Ba, ICLR 2015; beta .9, .999)
// on the mean squared error of coefficients. The basis is orthonormal, so that is the squared vertex error up to the
// constant the basis cannot hold; the wide vertex layer is never touched. The loss sees outputs minus those at rest, as
// a reader of the archive computes them.
//
// Same seed, same result, whatever the number of threads: a batch is cut into pieces of 64 poses whose gradients are
// added in order. Fails with internal if the loss stops being a number, with interrupted after saving the checkpoint.
TrainedLayers train_layers(const TrainingSet& set, const TrainingPlan& plan, Progress& progress);

}  // namespace fb
