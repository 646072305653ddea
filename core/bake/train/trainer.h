#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "base/parallel.h"
#include "base/progress.h"
#include "figures/training_figures.h"
#include "model/network.h"

namespace fb::bake {

// Training data of one network: features -> coefficients, one row a pose. Features are 0 at rest. Several networks may
// share one feature matrix, each with columns of its own.
struct TrainingSet {
  std::size_t poses = 0, inputs = 0, outputs = 0;
  std::span<const float> features;    // poses x stride
  std::span<const float> targets;     // poses x outputs
  std::span<const float> gates = {};  // one a pose, multiplies its outputs; empty: 1
  // Poses that are not trained on, ascending. The weights with the least error on them are returned; empty: the last
  // weights are.
  std::span<const std::uint32_t> validation = {};
  std::size_t stride = 0;                       // floats in a row of features; 0: inputs
  std::span<const std::uint32_t> columns = {};  // the row's columns that are the inputs; empty: the first ones
  // How strongly each input is expected to act: initial weights from it and their learning rate are multiplied by this.
  // What acts little is then learnt late, so that few poses do not teach chance; empty: 1.
  std::span<const float> input_scales = {};
};

// Learning-rate schedules.
enum class Schedule {
  cosine,               // half a cosine from 1 to 0
  warmup_stable_decay,  // linear rise over the first 3 % of the steps, constant, linear fall to 0 over the last half
};

struct TrainingPlan {
  std::vector<std::uint32_t> widths;         // of the hidden layers; a linear output layer follows
  Activation activation = Activation::relu;  // of the hidden layers
  Schedule schedule = Schedule::cosine;
  float learning_rate = 1e-3f;
  // Factors on the learning rate of the weights of hidden layers after the first, and of the output layer. How step
  // sizes should depend on the width of a layer: Yang, Hu, Tensor Programs IV, ICML 2021.
  float hidden_rate_factor = 1, output_rate_factor = 1;
  // Factor on the initial weights of layers with a residual connection. Small: the network starts nearly linear,
  // whatever its depth.
  float residual_init_scale = 0.1f;
  float weight_decay = 0;  // decoupled (Loshchilov, Hutter, ICLR 2019)
  // Scaling of the outputs, p in [0, 1]. With s_k the root mean square of coefficient k over the trained poses (at
  // least 1e-4 of the largest) and s that of all coefficients, coefficient k is s (s_k / s)^p times output k, and its
  // squared error has the loss weight (s_k / s)^(-p / 2). 0: plain mean squared error. 1: each output in units of its
  // own; a coefficient ten times smaller then has 3 times the weight of plain squares, where full normalisation would
  // give 100.
  float output_scaling = 0;
  // Balance of the loss between poses, p in [0, 1]. With e a pose's squared coefficients over their mean, its squared
  // error has the weight (0.2 + e)^-p, normalised to mean 1. 0: plain squares, dominated by the few poses furthest from
  // rest. With .25, errors fell at poses of every size; with .5 the mean fell further, but the worst vertex got worse.
  float pose_balance = 0;
  std::uint32_t batch = 256;
  // Poses that go through the network together, at most 128. As many threads as a batch has microbatches can work on
  // it; smaller microbatches cost time (64: about 15 %).
  std::uint32_t microbatch = 128;
  std::uint32_t epochs = 100;
  // Share of the epochs, the last ones, with quantisation-aware training: passes use weights quantised as packing does,
  // gradients go to the float weights (straight-through estimator). 0: none.
  float quantised_share = 0;
  int weight_bits = 8;
  std::uint64_t seed = 1;
  // Factors of the steps' products are rounded to bf16 where the processor multiplies them faster (Kernels::gemm_bf16);
  // sums, parameters and validation stay in float. On a Zen 5, steps take 0.5 to 0.6 of the time (bench_training); the
  // ten networks of MakeHuman's `hero`, 110,000 poses, leave 4.11 % of the squared residual either way.
  bool bf16 = false;
  // Layers to continue from instead of random initialisation; they set widths and activations, and the last must be
  // linear. With the outputs of another network (run_layers) as targets, this is distillation.
  std::vector<DenseLayer> initial_layers;
  Parallel parallel;
  std::filesystem::path checkpoint;  // written twice a minute and resumed from; empty: none
};

struct TrainedLayers {
  std::vector<DenseLayer> layers;
  double loss = 0;                     // training loss of the last epoch
  double validation = 0;               // validation loss of these layers; 0 without validation poses
  std::vector<EpochLoss> epochs = {};  // since this call started
  std::uint32_t restarts = 0;          // after divergence, each at half the learning rate
};

// Trains dense layers, with residual connections wherever widths are equal, by Adam (Kingma, Ba, ICLR 2015; beta .9,
// .999) on the mean squared error of coefficients. As the basis is orthonormal, that is the squared vertex error up to
// the constant truncation error; the wide vertex layer takes no part in training. The loss sees outputs minus those at
// rest, times gates, as the runtime computes them.
//
// With validation poses, their loss is measured at the ends of at most 20 epochs, and the weights with the least are
// returned; with a quantised share, it is the loss of quantised weights.
//
// Deterministic for a seed, whatever the number of threads: gradients of the microbatches are summed in order. When the
// loss is not finite, training restarts at half the learning rate; the fourth time it fails with internal. Fails with
// invalid_argument on a set or plan out of range, and with interrupted after saving the checkpoint.
// Memory: four times the parameters, for each microbatch the parameters and up to 129 poses' activations, and a copy of
// the inputs if the set names columns.
TrainedLayers train_layers(const TrainingSet& set, const TrainingPlan& plan, Progress& progress);

// Trains several networks, each with the result of train_layers; the plans' own `parallel` is ignored. Longest first:
// a network that would delay the others gets all threads, the rest run one a thread.
std::vector<TrainedLayers> train_in_parallel(std::span<const TrainingSet> sets, std::span<const TrainingPlan> plans,
                                             const Parallel& parallel, Progress& progress,
                                             std::string_view stage = "training");

// The outputs of layers (poses x outputs), minus those at rest, times gates, in float. Targets are ignored. Fails with
// invalid_argument if the layers do not fit the set.
std::vector<float> run_layers(const std::vector<DenseLayer>& layers, const TrainingSet& set, const Parallel& parallel);

}  // namespace fb::bake
