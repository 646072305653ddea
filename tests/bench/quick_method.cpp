#include "quick_method.h"

#include <algorithm>
#include <cmath>

namespace fb::bench {
using namespace fb::bake;
namespace {

constexpr std::size_t values = 5, block = 256;

float part_of_range(const Control& control, float value) {
  return (value - control.minimum) / (control.maximum - control.minimum);
}

}  // namespace

QuickMethod::QuickMethod(RigEvaluator& rig, std::size_t vertices) : rig_(rig), width_(rig.schema().control_count()) {
  const std::size_t all = rig.rest().points.size() / 3;
  for (std::size_t v = 0; v < vertices; ++v) vertices_.push_back(v * all / vertices);
  std::vector<float> controls;
  for (std::size_t c = 0; c < width_; ++c)
    for (std::size_t k = 0; k < values; ++k) {
      const Control& control = rig.schema().controls[c];
      const float t = static_cast<float>(k) / (values - 1);
      std::vector<float> pose = rig.schema().rest_pose();
      pose[c] = control.minimum * (1 - t) + control.maximum * t;
      controls.insert(controls.end(), pose.begin(), pose.end());
    }
  curves_ = displacements(controls);
  // So that the curve is 0 at rest, wherever rest is.
  for (std::size_t c = 0; c < width_; ++c) {
    const Control& control = rig.schema().controls[c];
    const float at = part_of_range(control, control.rest) * (values - 1);
    const std::size_t k = std::min<std::size_t>(values - 2, static_cast<std::size_t>(at));
    const float t = at - static_cast<float>(k);
    float* curve = curves_.data() + c * values * outputs();
    for (std::size_t i = 0; i < outputs(); ++i) {
      const float rest = curve[k * outputs() + i] * (1 - t) + curve[(k + 1) * outputs() + i] * t;
      for (std::size_t j = 0; j < values; ++j) curve[j * outputs() + i] -= rest;
    }
  }
}

std::vector<float> QuickMethod::displacements(std::span<const float> controls) const {
  const std::size_t poses = controls.size() / width_, size = rig_.rest().points.size();
  const float scale = static_cast<float>(1 / rig_.rest().diagonal());
  std::vector<float> points, sampled;
  for (std::size_t first = 0; first < poses; first += block) {
    const std::size_t count = std::min(block, poses - first);
    points.resize(count * size);
    rig_.evaluate(controls.subspan(first * width_, count * width_), count, points);
    for (std::size_t pose = 0; pose < count; ++pose)
      for (const std::size_t v : vertices_)
        for (std::size_t i = 3 * v; i < 3 * v + 3; ++i)
          sampled.push_back((points[pose * size + i] - rig_.rest().points[i]) * scale);
  }
  return sampled;
}

std::vector<float> QuickMethod::residuals_of(std::span<const float> controls) const {
  std::vector<float> residuals = displacements(controls);
  parallel_for(rig_.parallel(), controls.size() / width_, [&](std::size_t pose, std::size_t) {
    float* residual = residuals.data() + pose * outputs();
    for (std::size_t c = 0; c < width_; ++c) {
      const Control& control = rig_.schema().controls[c];
      if (controls[pose * width_ + c] == control.rest) continue;
      const float at = part_of_range(control, controls[pose * width_ + c]) * (values - 1);
      const std::size_t k = std::min<std::size_t>(values - 2, static_cast<std::size_t>(at));
      const float t = at - static_cast<float>(k);
      const float* low = curves_.data() + (c * values + k) * outputs();
      for (std::size_t i = 0; i < outputs(); ++i) residual[i] -= low[i] * (1 - t) + low[outputs() + i] * t;
    }
  });
  return residuals;
}

std::vector<float> QuickMethod::features(std::span<const float> controls) const {
  std::vector<float> features(controls.begin(), controls.end());
  for (std::size_t i = 0; i < features.size(); ++i) {
    const Control& control = rig_.schema().controls[i % width_];
    features[i] = (features[i] - control.rest) / control.reach();
  }
  return features;
}

std::vector<DenseLayer> QuickMethod::train(std::span<const float> controls, std::span<const float> residuals,
                                           const TrainingPlan& plan) const {
  const std::vector<float> inputs = features(controls);
  return train_layers({controls.size() / width_, width_, outputs(), inputs, residuals}, plan, silent_progress()).layers;
}

std::vector<float> QuickMethod::predict(const std::vector<DenseLayer>& layers, std::span<const float> controls) const {
  const std::vector<float> inputs = features(controls);
  const std::size_t poses = controls.size() / width_;
  std::vector<float> predicted(poses * outputs());
  const auto run = [&](const float* pose, float* out) {
    std::vector<float> in(pose, pose + width_), next;
    for (const DenseLayer& layer : layers) {
      next.assign(layer.bias.begin(), layer.bias.end());
      for (std::size_t o = 0; o < layer.outputs; ++o)
        for (std::size_t i = 0; i < layer.inputs; ++i) next[o] += layer.weights[o * layer.inputs + i] * in[i];
      if (layer.activation == Activation::relu)
        for (float& value : next) value = std::max(value, 0.0f);
      if (layer.skip)
        for (std::size_t o = 0; o < next.size(); ++o) next[o] += in[o];
      in.swap(next);
    }
    std::copy(in.begin(), in.end(), out);
  };
  std::vector<float> at_rest(outputs());
  run(std::vector<float>(width_).data(), at_rest.data());
  parallel_for(rig_.parallel(), poses, [&](std::size_t pose, std::size_t) {
    float* out = predicted.data() + pose * outputs();
    run(inputs.data() + pose * width_, out);
    for (std::size_t i = 0; i < outputs(); ++i) out[i] -= at_rest[i];
  });
  return predicted;
}

QuickErrors QuickMethod::errors(std::span<const float> predicted, std::span<const float> residuals) const {
  QuickErrors errors;
  const std::size_t poses = residuals.size() / outputs();
  for (std::size_t pose = 0; pose < poses; ++pose) {
    double worst = 0;
    for (std::size_t v = 0; v < vertices_.size(); ++v) {
      double squares = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t at = pose * outputs() + 3 * v + i;
        const double d = predicted.empty() ? residuals[at] : double(predicted[at]) - residuals[at];
        squares += d * d;
      }
      errors.mse += squares / static_cast<double>(poses * vertices_.size());
      worst = std::max(worst, std::sqrt(squares));
    }
    errors.max = std::max(errors.max, worst);
    errors.mfm += worst / static_cast<double>(poses);
  }
  return errors;
}

}  // namespace fb::bench
