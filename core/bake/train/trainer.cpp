#include "bake/train/trainer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "bake/linalg/gemm.h"
#include "bake/train/checkpoint.h"
#include "base/hash.h"
#include "base/random.h"
#include "base/status.h"

namespace fb {
namespace {

constexpr std::size_t piece_poses = 64;
constexpr float beta1 = 0.9f, beta2 = 0.999f, epsilon = 1e-8f;
constexpr double pi = 3.14159265358979323846;

// Where a layer's numbers lie in the flat vector of all parameters: weights (outputs x inputs, rows first), then bias.
struct Shape {
  std::size_t inputs, outputs, weights, bias;
  bool hidden, skip;
};

struct Shapes {
  std::vector<Shape> layers;
  std::size_t parameters = 0;

  Shapes(std::size_t inputs, const std::vector<std::uint32_t>& widths, std::size_t outputs) {
    for (const std::uint32_t width : widths) inputs = add(inputs, width, true);
    add(inputs, outputs, false);
  }

 private:
  std::size_t add(std::size_t inputs, std::size_t outputs, bool hidden) {
    layers.push_back({inputs, outputs, parameters, parameters + inputs * outputs, hidden,
                      hidden && inputs == outputs && !layers.empty()});
    parameters += (inputs + 1) * outputs;
    return outputs;
  }
};

// Forward and backward of up to piece_poses poses, and the rest pose as one more column: its outputs are subtracted
// from the others', so its gradient is minus the sum of theirs.
class Piece {
 public:
  explicit Piece(const Shapes& shapes) : shapes_(shapes), gradient_(shapes.parameters) {
    const auto buffer = [](std::size_t rows) { return std::vector<float>(rows * (piece_poses + 1)); };
    std::size_t widest = shapes.layers.front().inputs;
    signals_.push_back(buffer(widest));
    for (const Shape& layer : shapes.layers) {
      signals_.push_back(buffer(layer.outputs));
      activations_.push_back(buffer(layer.hidden ? layer.outputs : 0));
      widest = std::max(widest, layer.outputs);
    }
    down_ = buffer(widest);
    up_ = buffer(widest);
  }

  const std::vector<float>& gradient() const { return gradient_; }

  // Sum over these poses of |y - t|^2; leaves the gradient of `weight` times that sum in gradient().
  double run(const TrainingSet& set, std::span<const std::uint32_t> poses, const float* parameters, float target_scale,
             float weight) {
    columns_ = poses.size() + 1;
    float* input = signals_[0].data();
    for (const std::uint32_t pose : poses) {
      std::copy_n(set.features.data() + pose * set.inputs, set.inputs, input);
      input += set.inputs;
    }
    std::fill_n(input, set.inputs, 0.0f);
    for (std::size_t l = 0; l < shapes_.layers.size(); ++l) forward(l, parameters);

    // Loss and the gradient of the outputs.
    const std::size_t outputs = set.outputs;
    const float* y = signals_.back().data();
    const float* rest = y + poses.size() * outputs;
    float* rest_gradient = down_.data() + poses.size() * outputs;
    std::fill_n(rest_gradient, outputs, 0.0f);
    double loss = 0;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const float* target = set.targets.data() + poses[i] * outputs;
      float squares = 0;
      for (std::size_t k = 0; k < outputs; ++k) {
        const float error = y[i * outputs + k] - rest[k] - target[k] * target_scale;
        squares += error * error;
        down_[i * outputs + k] = 2 * weight * error;
        rest_gradient[k] -= 2 * weight * error;
      }
      loss += squares;
    }
    for (std::size_t l = shapes_.layers.size(); l-- > 0;) backward(l, parameters);
    return loss;
  }

 private:
  void forward(std::size_t l, const float* parameters) {
    const Shape& layer = shapes_.layers[l];
    const float* x = signals_[l].data();
    float* y = signals_[l + 1].data();
    gemm(Op::transposed, Op::plain, layer.outputs, columns_, layer.inputs, parameters + layer.weights, layer.inputs, x,
         layer.inputs, 0, y, layer.outputs);
    const float* bias = parameters + layer.bias;
    if (!layer.hidden) {
      for (std::size_t i = 0; i < columns_; ++i)
        for (std::size_t k = 0; k < layer.outputs; ++k) y[i * layer.outputs + k] += bias[k];
      return;
    }
    float* activation = activations_[l].data();
    for (std::size_t i = 0; i < columns_; ++i)
      for (std::size_t k = 0; k < layer.outputs; ++k) {
        const std::size_t at = i * layer.outputs + k;
        activation[at] = std::max(y[at] + bias[k], 0.0f);
        y[at] = activation[at] + (layer.skip ? x[at] : 0.0f);
      }
  }

  // Takes the gradient of the layer's outputs in down_ and leaves that of its inputs there.
  void backward(std::size_t l, const float* parameters) {
    const Shape& layer = shapes_.layers[l];
    const std::size_t count = columns_ * layer.outputs;
    if (layer.skip) std::copy_n(down_.data(), count, up_.data());
    float* bias = gradient_.data() + layer.bias;
    std::fill_n(bias, layer.outputs, 0.0f);
    // The last layer's bias cancels against the rest pose and stays 0.
    if (layer.hidden) {
      const float* activation = activations_[l].data();
      for (std::size_t i = 0; i < columns_; ++i)
        for (std::size_t k = 0; k < layer.outputs; ++k) {
          const std::size_t at = i * layer.outputs + k;
          down_[at] = activation[at] > 0 ? down_[at] : 0.0f;
          bias[k] += down_[at];
        }
    }
    gemm(Op::plain, Op::transposed, layer.inputs, layer.outputs, columns_, signals_[l].data(), layer.inputs,
         down_.data(), layer.outputs, 0, gradient_.data() + layer.weights, layer.inputs);
    if (l == 0) return;
    // With a skip the inputs' gradient is added to the copy of the outputs' (kept in up_).
    gemm(Op::plain, Op::plain, layer.inputs, columns_, layer.outputs, parameters + layer.weights, layer.inputs,
         down_.data(), layer.outputs, layer.skip ? 1.0f : 0.0f, up_.data(), layer.inputs);
    std::swap(down_, up_);
  }

  const Shapes& shapes_;
  std::size_t columns_ = 0;
  std::vector<std::vector<float>> signals_, activations_;  // of each layer: what goes in, what the ReLU lets through
  std::vector<float> down_, up_;                           // gradients on their way to the first layer
  std::vector<float> gradient_;
};

struct State {
  std::vector<float> parameters, mean, square;  // Adam's moments
  std::uint64_t step = 0;
};

// He's initialisation; layers that add to a skip begin small, so that the network begins nearly linear whatever its
// depth, and the last layer begins at 0: at first nothing moves.
State initial_state(const Shapes& shapes, std::uint64_t seed) {
  State state;
  state.parameters.assign(shapes.parameters, 0.0f);
  state.mean = state.square = state.parameters;
  for (std::size_t l = 0; l < shapes.layers.size(); ++l) {
    const Shape& layer = shapes.layers[l];
    Random random(seed, l);
    if (!layer.hidden) continue;
    const float deviation = std::sqrt(2.0f / layer.inputs) * (layer.skip ? 0.1f : 1.0f);
    for (std::size_t i = 0; i < layer.inputs * layer.outputs; ++i)
      state.parameters[layer.weights + i] = deviation * random.normal();
  }
  return state;
}

// The order of poses in an epoch: a Fisher-Yates shuffle of its own stream.
std::vector<std::uint32_t> shuffled(std::size_t poses, std::uint64_t seed, std::uint64_t epoch) {
  std::vector<std::uint32_t> order(poses);
  std::iota(order.begin(), order.end(), 0u);
  Random random(seed, 0x10000 + epoch);
  for (std::size_t i = poses; i > 1; --i) std::swap(order[i - 1], order[random.below(static_cast<std::uint32_t>(i))]);
  return order;
}

// Adds the pieces' gradients in order and steps.
void adam(State& state, const std::vector<Piece>& pieces, float rate, const Parallel& parallel) {
  const float correction1 = 1 - std::pow(beta1, static_cast<float>(state.step + 1));
  const float correction2 = 1 - std::pow(beta2, static_cast<float>(state.step + 1));
  const float scaled_rate = rate / correction1, root_correction = 1 / std::sqrt(correction2);
  constexpr std::size_t slice = 1 << 15;
  const std::size_t total = state.parameters.size();
  parallel_for(parallel, (total + slice - 1) / slice, [&](std::size_t s, std::size_t) {
    float* __restrict parameters = state.parameters.data();
    float* __restrict mean = state.mean.data();
    float* __restrict square = state.square.data();
    const std::size_t first = s * slice, last = std::min(first + slice, total);
    float gradient[256];
    for (std::size_t begin = first; begin < last; begin += 256) {
      const std::size_t count = std::min<std::size_t>(256, last - begin);
      std::copy_n(pieces[0].gradient().data() + begin, count, gradient);
      for (std::size_t p = 1; p < pieces.size(); ++p) {
        const float* more = pieces[p].gradient().data() + begin;
        for (std::size_t i = 0; i < count; ++i) gradient[i] += more[i];
      }
      for (std::size_t i = 0; i < count; ++i) {
        float& m = mean[begin + i];
        float& v = square[begin + i];
        m = beta1 * m + (1 - beta1) * gradient[i];
        v = beta2 * v + (1 - beta2) * gradient[i] * gradient[i];
        parameters[begin + i] -= scaled_rate * m / (std::sqrt(v) * root_correction + epsilon);
      }
    }
  });
}

// What a checkpoint must have been made from to be gone on with.
std::uint64_t key_of(const TrainingSet& set, const TrainingPlan& plan) {
  std::vector<std::uint64_t> numbers = {set.poses,
                                        set.inputs,
                                        set.outputs,
                                        plan.batch,
                                        plan.epochs,
                                        plan.seed,
                                        static_cast<std::uint64_t>(plan.learning_rate * 1e9)};
  numbers.insert(numbers.end(), plan.widths.begin(), plan.widths.end());
  return hash64_of<std::uint64_t>(numbers, hash64_of(set.features, hash64_of(set.targets)));
}

std::vector<DenseLayer> layers_of(const Shapes& shapes, const std::vector<float>& parameters, float output_scale) {
  std::vector<DenseLayer> layers;
  for (const Shape& shape : shapes.layers) {
    DenseLayer layer;
    layer.inputs = static_cast<std::uint32_t>(shape.inputs);
    layer.outputs = static_cast<std::uint32_t>(shape.outputs);
    layer.activation = shape.hidden ? Activation::relu : Activation::linear;
    layer.skip = shape.skip;
    const auto weights = parameters.begin() + shape.weights, bias = parameters.begin() + shape.bias;
    layer.weights.assign(weights, bias);
    layer.bias.assign(bias, bias + shape.outputs);
    if (!shape.hidden)
      for (float& weight : layer.weights) weight *= output_scale;
    layers.push_back(std::move(layer));
  }
  return layers;
}

}  // namespace

TrainedLayers train_layers(const TrainingSet& set, const TrainingPlan& plan, Progress& progress) {
  if (set.poses == 0 || set.features.size() != set.poses * set.inputs || set.targets.size() != set.poses * set.outputs)
    fail(Status::invalid_argument, "training: %zu poses with %zu features and %zu targets", set.poses,
         set.features.size(), set.targets.size());
  const Shapes shapes(set.inputs, plan.widths, set.outputs);
  double squares = 0;
  for (const float target : set.targets) squares += double(target) * target;
  // What one unit of the outputs is: the root mean square of all coefficients. Adam's step is absolute, so this
  // matters.
  const double size = std::sqrt(squares / set.targets.size());
  if (!(size > 0)) fail(Status::bad_data, "training: all coefficients are 0");

  const std::uint64_t key = plan.checkpoint.empty() ? 0 : key_of(set, plan);
  State state = initial_state(shapes, plan.seed);
  const std::size_t batch = std::min<std::size_t>(plan.batch, set.poses);
  const std::uint64_t steps_per_epoch = set.poses / batch, steps = steps_per_epoch * plan.epochs;
  if (!plan.checkpoint.empty())
    if (auto saved = load_checkpoint(plan.checkpoint, key); saved && saved->arrays.size() == 3)
      state = {std::move(saved->arrays[0]), std::move(saved->arrays[1]), std::move(saved->arrays[2]), saved->step};
  const auto save = [&] {
    if (!plan.checkpoint.empty())
      save_checkpoint(plan.checkpoint, {key, state.step, {state.parameters, state.mean, state.square}});
  };

  std::vector<Piece> pieces((batch + piece_poses - 1) / piece_poses, Piece(shapes));
  std::vector<double> losses(pieces.size());
  std::vector<std::uint32_t> order;
  double loss = 0;
  auto last_save = std::chrono::steady_clock::now();
  progress.begin("training", steps);
  for (; state.step < steps; ++state.step) {
    const std::uint64_t step = state.step % steps_per_epoch;
    if (order.empty() || step == 0) {
      order = shuffled(set.poses, plan.seed, state.step / steps_per_epoch);
      loss = 0;
    }
    const std::span<const std::uint32_t> poses = std::span(order).subspan(step * batch, batch);
    parallel_for(plan.parallel, pieces.size(), [&](std::size_t p, std::size_t) {
      const std::size_t first = p * piece_poses, count = std::min(piece_poses, batch - first);
      losses[p] = pieces[p].run(set, poses.subspan(first, count), state.parameters.data(), static_cast<float>(1 / size),
                                1.0f / static_cast<float>(batch));
    });
    for (const double part : losses) loss += part / static_cast<double>(batch * steps_per_epoch * set.outputs);
    if (!std::isfinite(loss))
      fail(Status::internal, "training diverged at step %llu of %llu: the loss is not a number",
           static_cast<unsigned long long>(state.step), static_cast<unsigned long long>(steps));
    const double rate = plan.learning_rate * 0.5 * (1 + std::cos(pi * static_cast<double>(state.step) / steps));
    adam(state, pieces, static_cast<float>(rate), plan.parallel);

    progress.update(state.step + 1);
    const auto now = std::chrono::steady_clock::now();
    if (progress.cancelled() || now - last_save > std::chrono::seconds(30)) {
      ++state.step;
      save();
      last_save = now;
      progress.step(state.step);
      --state.step;
    }
  }
  save();
  return {layers_of(shapes, state.parameters, static_cast<float>(size)), loss};
}

}  // namespace fb
