#include "runtime/derivative/region_derivative.h"

#include <algorithm>
#include <cmath>

namespace fb::runtime {
namespace {

std::size_t padded(std::size_t count) {
  return (count + padding - 1) / padding * padding;
}

// An activation's value, and its slope there; see activation.h.
float activated(Activation activation, float x, float& slope) {
  switch (activation) {
    case Activation::relu:
      slope = x > 0 ? 1.0f : 0.0f;
      return x > 0 ? x : 0.0f;
    case Activation::tanh: {
      const float y = rational_tanh(x);
      slope = 1.0f - y * y;
      return y;
    }
    case Activation::silu: {
      const float t = rational_tanh(0.5f * x), sigmoid = 0.5f + 0.5f * t;
      slope = sigmoid + x * (0.25f * (1.0f - t * t));
      return x * sigmoid;
    }
    default:
      slope = 1.0f;
      return x;
  }
}

}  // namespace

RegionDerivative::Layer::Layer(const RegionNetwork& network, std::size_t number, std::pmr::memory_resource& memory)
    : form(network.layer_form(number)),
      stride(padded(form.inputs)),
      weights(stride * form.outputs, &memory),
      bias(padded(form.outputs), &memory),
      slopes(padded(form.outputs), &memory) {
  network.copy_layer(number, stride, weights.data(), bias.data());
}

RegionDerivative::RegionDerivative(const EvaluationLayout& layout, std::size_t region,
                                   const FeatureDerivatives& features, std::span<const float> sums,
                                   std::pmr::memory_resource& memory)
    : gate_slope_(layout.gate_slopes[region]),
      layers_(&memory),
      outputs_(layout.networks[region].output_count()),
      output_stride_(padded(outputs_)),
      count_(sums.size() / outputs_),
      sums_(count_ * output_stride_, &memory),
      inputs_(&memory),
      gate_features_(&memory),
      controls_(&memory),
      places_(&memory),
      values_(&memory),
      next_(&memory),
      rest_outputs_(&memory),
      sum_values_(count_, &memory),
      by_last_(&memory),
      by_inputs_(&memory),
      work_(&memory),
      by_gate_(&memory),
      derivatives_(&memory) {
  const RegionNetwork& network = layout.networks[region];
  layers_.reserve(network.layer_count());
  for (std::size_t l = 0; l < network.layer_count(); ++l) layers_.emplace_back(network, l, memory);
  width_ = padded(network.max_width());
  for (std::size_t k = 0; k < count_; ++k)
    std::copy_n(sums.begin() + std::ptrdiff_t(k * outputs_), outputs_,
                sums_.begin() + std::ptrdiff_t(k * output_stride_));
  add_features(layout, region, features);
  for (std::pmr::vector<float>* row : {&values_, &next_, &rest_outputs_}) row->resize(width_);
  for (std::pmr::vector<float>* rows : {&by_last_, &by_inputs_, &work_}) rows->resize(count_ * width_);
  control_stride_ = padded(controls_.size());
  by_gate_.resize(control_stride_);
  derivatives_.resize(count_ * control_stride_);
  run_network(layout.kernels);
  rest_outputs_ = values_;
  start_rows(layout.kernels);
}

// The layout says where each feature goes, not what each input is.
void RegionDerivative::add_features(const EvaluationLayout& layout, std::size_t region,
                                    const FeatureDerivatives& features) {
  const RegionNetwork& network = layout.networks[region];
  inputs_.resize(network.input_count());
  for (std::uint32_t f = 0; f < layout.features.feature_count(); ++f)
    for (const EvaluationLayout::ScatterEntry& entry : layout.scatter.row(f)) {
      if (entry.list == region) inputs_[network.input_at(entry.offset)].feature = f;
      if (entry.list == layout.gate_list(region)) gate_features_.push_back({f, 0});
      if (entry.list != region && entry.list != layout.gate_list(region)) continue;
      const auto of = features.controls(f);
      controls_.insert(controls_.end(), of.begin(), of.end());
    }
  std::sort(controls_.begin(), controls_.end());
  controls_.erase(std::unique(controls_.begin(), controls_.end()), controls_.end());
  for (std::pmr::vector<FeatureControls>* list : {&inputs_, &gate_features_})
    for (FeatureControls& of : *list) {
      of.first = static_cast<std::uint32_t>(places_.size());
      for (const std::uint32_t control : features.controls(of.feature))
        places_.push_back(static_cast<std::uint32_t>(std::lower_bound(controls_.begin(), controls_.end(), control) -
                                                     controls_.begin()));
    }
}

// From values_, the inputs, to values_, the outputs.
void RegionDerivative::run_network(const PoseKernels& kernels) {
  for (Layer& layer : layers_) {
    std::fill(values_.begin() + layer.form.inputs, values_.begin() + std::ptrdiff_t(layer.stride), 0.0f);
    kernels.dot_products(values_.data(), layer.weights.data(), layer.stride, layer.form.outputs, layer.stride,
                         next_.data());
    for (std::uint32_t o = 0; o < layer.form.outputs; ++o) {
      next_[o] = activated(layer.form.activation, next_[o] + layer.bias[o], layer.slopes[o]);
      if (layer.form.skip) next_[o] += values_[o];
    }
    std::swap(values_, next_);
  }
}

// by_last_, of what the last layer does in the current pose.
void RegionDerivative::start_rows(const PoseKernels& kernels) {
  const Layer& last = layers_.back();
  for (std::size_t k = 0; k < count_; ++k) {
    float *const row = by_last_.data() + k * width_, *const factors = next_.data();
    const float* const sum = sums_.data() + k * output_stride_;
    for (std::size_t o = 0; o < outputs_; ++o) factors[o] = sum[o] * last.slopes[o];
    std::fill_n(row, last.stride, 0.0f);
    if (last.form.skip) std::copy_n(sum, outputs_, row);
    kernels.add_rows(row, factors, last.weights.data(), last.stride, outputs_, last.stride);
  }
}

// The derivatives of the sums by the inputs of layer after layer, from the last but one to the first: by_inputs_.
void RegionDerivative::pull_back(const PoseKernels& kernels) {
  if (layers_.back().form.activation != Activation::linear) start_rows(kernels);
  std::pmr::vector<float>*rows = &by_inputs_, *next = &work_;
  if (layers_.size() % 2 == 0) std::swap(rows, next);  // so that the last ones are in by_inputs_
  std::copy(by_last_.begin(), by_last_.end(), rows->begin());
  for (std::size_t l = layers_.size() - 1; l > 0; --l) {
    const Layer& layer = layers_[l - 1];
    for (std::size_t k = 0; k < count_; ++k) {
      float *const row = rows->data() + k * width_, *const to = next->data() + k * width_;
      if (layer.form.skip)
        std::copy_n(row, layer.stride, to);
      else
        std::fill_n(to, layer.stride, 0.0f);
      for (std::uint32_t o = 0; o < layer.form.outputs; ++o) row[o] *= layer.slopes[o];
    }
    kernels.add_products({next->data(), width_, count_}, {rows->data(), width_, count_}, layer.weights.data(),
                         layer.stride, layer.form.outputs, layer.stride);
    std::swap(rows, next);
  }
}

void RegionDerivative::add_feature(const FeatureDerivatives& features, const FeatureControls& of, float factor,
                                   float* to) const {
  const std::uint32_t* place = &places_[of.first];
  for (const float derivative : features.of(of.feature)) to[*place++] += factor * derivative;
}

// Finds its derivative, by_gate_, and returns its value.
float RegionDerivative::gate(const FeatureDerivatives& features) {
  std::fill(by_gate_.begin(), by_gate_.end(), 0.0f);
  if (gate_slope_ == 0) return 1;
  float sum = 0, largest = 0;
  const FeatureControls* of_largest = nullptr;
  for (const FeatureControls& of : gate_features_) {
    const float size = std::fabs(features.value(of.feature));
    sum += size;
    if (size > largest) of_largest = &of;
    largest = size > largest ? size : largest;
  }
  const float value = gate_slope_ * (sum - largest);
  if (!(value < 1)) return 1;
  if (!of_largest) return 0;  // one feature alone opens no gate
  for (const FeatureControls& of : gate_features_) {
    if (&of == of_largest) continue;
    const float at = features.value(of.feature);
    float sign = at < 0 ? -1.0f : 1.0f;
    if (at == 0 && !features.of(of.feature).empty()) {  // it grows to the side to which its control moves
      const float rate = features.of(of.feature)[0] * features.direction(features.controls(of.feature)[0]);
      sign = rate < 0 ? -1.0f : 1.0f;
    }
    add_feature(features, of, gate_slope_ * sign, by_gate_.data());
  }
  return value > 0 ? value : 0;
}

void RegionDerivative::run(const PoseKernels& kernels, const FeatureDerivatives& features) {
  if (count_ == 0) return;
  std::fill(derivatives_.begin(), derivatives_.end(), 0.0f);
  bool active = false;
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    values_[i] = features.value(inputs_[i].feature);
    active |= values_[i] != 0;
  }
  const float value = gate(features);
  if (value == 0 && !active) return;
  run_network(kernels);
  std::fill(values_.begin() + std::ptrdiff_t(outputs_), values_.begin() + std::ptrdiff_t(output_stride_), 0.0f);
  for (std::size_t o = 0; o < outputs_; ++o) values_[o] = active ? values_[o] - rest_outputs_[o] : 0;
  kernels.dot_products(values_.data(), sums_.data(), output_stride_, count_, output_stride_, sum_values_.data());
  if (value != 0) pull_back(kernels);
  for (std::size_t k = 0; k < count_; ++k) {
    float* const to = derivatives_.data() + k * control_stride_;
    kernels.add_rows(to, &sum_values_[k], by_gate_.data(), control_stride_, 1, control_stride_);
    if (value == 0) continue;
    const float* const by_input = by_inputs_.data() + k * width_;
    for (std::size_t i = 0; i < inputs_.size(); ++i) add_feature(features, inputs_[i], value * by_input[i], to);
  }
}

}  // namespace fb::runtime
