// Through a network and back: what training and running layers share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bake/train/trainer.h"

namespace fb::bake {

// Where a layer's numbers lie in the flat vector of all: weights (outputs x inputs, row after row), and bias.
struct LayerShape {
  std::size_t inputs, outputs;
  Activation activation;
  bool skip;
  std::size_t weights, bias;
};

// A network's shape: all weights come first in the vector, then all biases.
struct NetShape {
  std::vector<LayerShape> layers;
  std::size_t weights = 0, parameters = 0;

  // Of a plan's network, with skips wherever widths allow.
  NetShape(std::size_t inputs, const TrainingPlan& plan, std::size_t outputs);
  explicit NetShape(const std::vector<DenseLayer>& layers);

 private:
  void place();
};

std::vector<float> parameters_of(const NetShape& shape, const std::vector<DenseLayer>& layers);
std::vector<DenseLayer> layers_of(const NetShape& shape, const std::vector<float>& parameters);

// In what units each coefficient is learnt, coefficient = unit * output of the last layer, and what the loss multiplies
// squared errors of each coefficient and of each pose with.
struct LossScale {
  std::vector<float> unit, weight;
  std::vector<float> pose_weight;  // empty: 1
};

// Fails unless features, columns and gates fit the poses.
void check_features(const TrainingSet& set);

// Poses that go through a network together, and the rest pose as one more: its outputs are subtracted from the others',
// so its gradient is minus the sum of theirs.
class DensePass {
 public:
  static constexpr std::size_t most_poses = 128;

  explicit DensePass(const NetShape& shape);

  // Outputs of up to most_poses poses minus those at rest, times gates: outputs numbers a pose, valid until the next
  // call.
  std::span<const float> run(const TrainingSet& set, std::span<const std::uint32_t> poses, const float* parameters);

  // Sum of squared errors of coefficients; leaves the gradient of `scale` times the weighted sum in gradient().
  double learn(const TrainingSet& set, std::span<const std::uint32_t> poses, const float* parameters,
               const LossScale& scales, float scale);
  // What learn returns, without learning.
  double test(const TrainingSet& set, std::span<const std::uint32_t> poses, const float* parameters,
              const LossScale& scales);
  const std::vector<float>& gradient() const { return gradient_; }

 private:
  void forward(const TrainingSet& set, std::span<const std::uint32_t> poses, const float* parameters, bool learns);
  double errors(const TrainingSet& set, std::span<const std::uint32_t> poses, const LossScale& scales);
  void backward(std::size_t l, const float* parameters);

  const NetShape& shape_;
  std::size_t columns_ = 0;
  std::vector<std::vector<float>> signals_, slopes_;  // what goes into each layer; derivatives of its activation
  std::vector<float> down_, up_;                      // gradients on their way to the first layer
  std::vector<float> gradient_;
};

}  // namespace fb::bake
