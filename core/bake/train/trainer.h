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
  std::span<const float> features;    // poses x inputs
  std::span<const float> targets;     // poses x outputs
  std::span<const float> gates = {};  // poses: what the gate multiplies the outputs with; empty: 1
  // Poses never trained on, ascending, by whose error the best moment is kept; empty: none, the last is kept.
  std::span<const std::uint32_t> validation = {};
};

enum class Schedule {
  cosine,  // falls along a half cosine
  linger,  // rises over the first 3 %, stays, and falls to 0 in a straight line over the last half
};

struct TrainingPlan {
  std::vector<std::uint32_t> widths;         // of the hidden layers; a last linear layer to the coefficients follows
  Activation activation = Activation::relu;  // of the hidden layers
  Schedule schedule = Schedule::cosine;
  float learning_rate = 1e-3f;
  float weight_decay = 0;  // decoupled (Loshchilov, Hutter, ICLR 2019)
  // Outputs are learnt in units of their own deviation over the poses to this power, and the loss weighs them so:
  // 0 leaves all in one unit; see the implementation for the formula.
  float output_scaling = 0;
  std::uint32_t batch = 256;
  std::uint32_t epochs = 100;
  // The last part of the epochs runs through weights rounded as the archive will round them (straight-through
  // gradients); 0: none.
  float quantized_share = 0;
  int weight_bits = 8;
  std::uint64_t seed = 1;
  Parallel parallel;
  std::filesystem::path checkpoint;  // saved twice a minute and gone on from; empty: none
};

// How training went, once an epoch.
struct EpochLoss {
  double training = 0, validation = 0;  // squared coefficient error over squared coefficients
};

struct TrainedLayers {
  std::vector<DenseLayer> layers;
  // Mean over the last epoch of squared coefficient error over squared coefficients; too small if this call went on
  // from the middle of that epoch.
  double loss = 0;
  std::vector<EpochLoss> epochs = {};  // since this call began
  std::uint32_t restarts = 0;          // after the loss stopped being a number; each at half the rate
};

// Trains dense layers with additive skips (where widths allow) by Adam (Kingma, Ba, ICLR 2015; beta .9, .999)
// on the mean squared error of coefficients. The basis is orthonormal, so that is the squared vertex error up to the
// constant the basis cannot hold; the wide vertex layer is never touched. The loss sees outputs minus those at rest, as
// a reader of the archive computes them.
//
// Same seed, same result, whatever the number of threads: a batch is cut into pieces of 64 poses whose gradients are
// added in order. Fails with internal if the loss stops being a number again and again, with interrupted after saving
// the checkpoint.
TrainedLayers train_layers(const TrainingSet& set, const TrainingPlan& plan, Progress& progress);

// Several networks, as many at a time as there are threads, the largest first; each as train_layers gives it.
std::vector<TrainedLayers> train_regions(std::span<const TrainingSet> sets, std::span<const TrainingPlan> plans,
                                         const Parallel& parallel, Progress& progress);

// Outputs (poses x outputs, minus those at rest, times gates) of trained layers, in float.
std::vector<float> run_layers(const std::vector<DenseLayer>& layers, const TrainingSet& set, const Parallel& parallel);

}  // namespace fb
