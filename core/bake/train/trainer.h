#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "base/parallel.h"
#include "base/progress.h"
#include "model/network.h"

namespace fb::bake {

// What a region network learns: features of a pose -> coefficients. Row after row, one row a pose; features are 0 at
// rest. Several networks may share one matrix of all features, each naming its own columns of it.
struct TrainingSet {
  std::size_t poses = 0, inputs = 0, outputs = 0;
  std::span<const float> features;    // poses x stride
  std::span<const float> targets;     // poses x outputs
  std::span<const float> gates = {};  // poses: what the gate multiplies the outputs with; empty: 1
  // Poses never trained on, ascending, by whose error the best moment is kept; empty: none, the last is kept.
  std::span<const std::uint32_t> validation = {};
  std::size_t stride = 0;                       // numbers in a row of features; 0: inputs
  std::span<const std::uint32_t> columns = {};  // of a row, those that are the inputs; empty: the first ones
};

enum class Schedule {
  cosine,               // falls along a half cosine
  warmup_stable_decay,  // rises over the first 3 %, stays, and falls to 0 in a straight line over the last half
};

struct TrainingPlan {
  std::vector<std::uint32_t> widths;         // of the hidden layers; a last linear layer to the coefficients follows
  Activation activation = Activation::relu;  // of the hidden layers
  Schedule schedule = Schedule::cosine;
  float learning_rate = 1e-3f;
  // What the rate is multiplied with for weights of hidden layers but the first, and for those of the last layer. That
  // layers want rates of their own is known from how steps should shrink with width (Yang, Hu, Tensor Programs IV,
  // ICML 2021).
  float hidden_rate = 1, last_rate = 1;
  // How large weights of layers that add to a skip begin, over the usual: small, and the network begins nearly linear
  // whatever its depth.
  float skip_start = 0.1f;
  float weight_decay = 0;  // decoupled (Loshchilov, Hutter, ICLR 2019)
  // How far outputs are learnt each in its own unit, p in [0, 1]. With s_k the root mean square of coefficient k over
  // the trained poses (at least 1e-4 of the largest) and s that of all coefficients, coefficient k is
  // s (s_k / s)^p times what the last layer learns, and the loss weighs its squared error with (s_k / s)^(-p / 2).
  // 0: one unit and plain squared errors. 1: each its own unit; a coefficient ten times smaller then weighs 3 times
  // more than in plain squares, where each weighing the same whatever its size would be 100 times.
  float output_scaling = 0;
  // How far poses count the same however much they ask for, p in [0, 1]. With e a pose's squared coefficients over
  // their mean over trained poses, its squared error weighs (0.2 + e)^-p, over the mean of that. 0: plain squared
  // errors, whose gradients are those of the few poses furthest out. With .25, networks came out better at poses of
  // every size; with .5 better still on the whole, but worse at the worst vertex.
  float pose_balance = 0;
  std::uint32_t batch = 256;
  // Poses of a batch that go through the network together, at most 128: as many threads as a batch has such pieces can
  // learn beside each other, but smaller ones take longer (64: by about 15 %).
  std::uint32_t microbatch = 128;
  std::uint32_t epochs = 100;
  // The last part of the epochs runs through weights rounded as the archive will round them (straight-through
  // gradients); 0: none.
  float quantized_share = 0;
  int weight_bits = 8;
  std::uint64_t seed = 1;
  // Layers to go on from instead of random ones; widths and activation are then theirs, and the last must be linear.
  // With another network's outputs (run_layers) as targets this distils that network.
  std::vector<DenseLayer> start;
  Parallel parallel;
  std::filesystem::path checkpoint;  // saved twice a minute and gone on from; empty: none
};

// How training went, once an epoch.
struct EpochLoss {
  double training = 0;    // squared coefficient error over squared coefficients, mean over the epoch
  double validation = 0;  // the same over validation poses, as last measured
};

struct TrainedLayers {
  std::vector<DenseLayer> layers;
  double loss = 0;        // mean over the last epoch of squared coefficient error over squared coefficients
  double validation = 0;  // the same of these layers over validation poses; 0 without any
  std::vector<EpochLoss> epochs = {};  // since this call began
  std::uint32_t restarts = 0;          // after the loss stopped being a number; each at half the rate
};

// Trains dense layers with additive skips (where widths allow) by Adam (Kingma, Ba, ICLR 2015; beta .9, .999)
// on the mean squared error of coefficients. The basis is orthonormal, so that is the squared vertex error up to the
// constant the basis cannot hold; the wide vertex layer is never touched. The loss sees outputs minus those at rest,
// times gates, as a reader of the archive computes them.
//
// With validation poses, their error is measured after at most 20 epochs of a training, and the weights with the least
// are given back; where a share of the epochs is quantised, it is the error through rounded weights.
//
// Same seed, same result, whatever the number of threads: a batch is cut into pieces whose gradients are added in
// order. When the loss stops being a number, training begins again at half the rate; the fourth time it fails
// with internal. Fails with interrupted after saving the checkpoint.
// Memory: a checkpoint's worth (four times the parameters), and once the parameters and up to 129 poses' signals a
// piece.
TrainedLayers train_layers(const TrainingSet& set, const TrainingPlan& plan, Progress& progress);

// Several networks, each exactly as train_layers gives it; the plans' own `parallel` is not used. The largest come
// first: one that would hold the others up has all threads to itself, the rest run one a thread.
std::vector<TrainedLayers> train_regions(std::span<const TrainingSet> sets, std::span<const TrainingPlan> plans,
                                         const Parallel& parallel, Progress& progress,
                                         std::string_view stage = "training");

// Outputs (poses x outputs, minus those at rest, times gates) of trained layers, in float; targets are not looked at.
std::vector<float> run_layers(const std::vector<DenseLayer>& layers, const TrainingSet& set, const Parallel& parallel);

}  // namespace fb::bake
