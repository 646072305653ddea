// Forward and backward pass through dense layers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bake/train/loss_weights.h"
#include "bake/train/trainer.h"

namespace fb::bake {

// A layer, and the offsets of its weights (outputs x inputs, row-major) and bias in the parameter vector.
struct LayerShape {
  std::size_t inputs, outputs;
  Activation activation;
  bool skip;  // with a residual connection
  std::size_t weights, bias;
};

// The layers of a network and the layout of its parameter vector: all weights first, then all biases.
struct NetworkShape {
  std::vector<LayerShape> layers;
  std::size_t weights = 0, parameters = 0;  // how many

  // The network of a plan, with residual connections wherever widths are equal.
  NetworkShape(std::size_t inputs, const TrainingPlan& plan, std::size_t outputs);
  explicit NetworkShape(const std::vector<DenseLayer>& layers);

 private:
  void assign_offsets();
};

std::vector<float> flatten_layers(const NetworkShape& shape, const std::vector<DenseLayer>& layers);
std::vector<DenseLayer> unflatten_layers(const NetworkShape& shape, const std::vector<float>& parameters);

// Fails with invalid_argument unless features, columns and gates fit the poses.
void check_features(const TrainingSet& set);

// The forward and backward pass of one microbatch. The rest pose goes along as one more column: its outputs are
// subtracted from the others', so its output gradient is minus the sum of theirs. Not thread-safe: one object a thread.
class DensePass {
 public:
  static constexpr std::size_t max_poses = 128;

  // bf16: see TrainingPlan, for loss_and_gradient.
  explicit DensePass(const NetworkShape& shape, bool bf16 = false);

  // Outputs of up to max_poses poses minus those at rest, times gates: `outputs` floats a pose, valid until the next
  // call.
  std::span<const float> outputs(const TrainingSet& set, std::span<const std::uint32_t> poses, const float* parameters);

  // Sum of squared coefficient errors.
  double loss(const TrainingSet& set, std::span<const std::uint32_t> poses, const float* parameters,
              const LossWeights& weights);
  // The same; gradient() becomes that of `scale` times the weighted loss.
  double loss_and_gradient(const TrainingSet& set, std::span<const std::uint32_t> poses, const float* parameters,
                           const LossWeights& weights, float scale);
  const std::vector<float>& gradient() const { return gradient_; }

 private:
  void forward(const TrainingSet& set, std::span<const std::uint32_t> poses, const float* parameters,
               bool keep_derivatives);
  double coefficient_errors(const TrainingSet& set, std::span<const std::uint32_t> poses, const LossWeights& weights);
  void backward(std::size_t layer, const float* parameters);

  const NetworkShape& shape_;
  const bool bf16_;
  std::size_t columns_ = 0;                                // poses and the rest pose
  std::vector<std::vector<float>> signals_, derivatives_;  // inputs of each layer and outputs; of its activation
  std::vector<float> output_gradient_, input_gradient_;    // of the layer that the backward pass is at
  std::vector<float> gradient_;                            // of the parameters
};

}  // namespace fb::bake
