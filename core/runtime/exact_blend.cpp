#include "runtime/exact_blend.h"

#include <algorithm>

namespace fb::runtime {

ExactBlend::State::State(const ExactBlend& blend, std::size_t poses, std::pmr::memory_resource& memory)
    : places(blend.empty() ? 0 : blend.controls_.size(), &memory),
      weights(blend.falloffs_.size() * poses, &memory),
      found(blend.empty() ? 0 : poses, &memory) {}

ExactBlend::ExactBlend(const PackedModel& model, std::pmr::memory_resource& memory)
    : controls_(&memory),
      falloffs_(&memory),
      places_(&memory),
      starts_(&memory),
      row_counts_(&memory),
      values_(&memory) {
  if (model.exact.empty()) return;
  const auto moves = [](const ExactPose& pose, const PackedRowBlock& block) {
    const auto first = pose.values.begin() + block.first_row;
    return std::any_of(first, first + block.row_count, [](std::int32_t value) { return value != 0; });
  };
  for (const Control& control : model.schema.controls)
    controls_.push_back({control.minimum, control.maximum - control.minimum, control.maximum});
  std::size_t values = 0;
  for (const ExactPose& pose : model.exact)
    for (const PackedRowBlock& block : model.row_blocks) values += moves(pose, block) ? block.row_count : 0;
  values_.reserve(values);
  places_.reserve(model.exact.size() * controls_.size());
  starts_.reserve(model.exact.size() * model.row_blocks.size());
  for (const PackedRowBlock& block : model.row_blocks) row_counts_.push_back(block.row_count);
  for (const ExactPose& pose : model.exact) {
    falloffs_.push_back(pose.falloff);
    for (std::size_t c = 0; c < controls_.size(); ++c)
      places_.push_back(place_in_range(model.schema.controls[c], pose.controls[c]));
    for (const PackedRowBlock& block : model.row_blocks) {
      starts_.push_back(moves(pose, block) ? values_.size() : none);
      if (starts_.back() == none) continue;
      for (std::uint32_t row = block.first_row; row < block.first_row + block.row_count; ++row)
        values_.push_back(pose.step * static_cast<float>(pose.values[row]));
    }
  }
}

void ExactBlend::find_places(const float* controls, State& state) const {
  for (std::size_t c = 0; c < controls_.size(); ++c) {
    const ControlRange& range = controls_[c];
    const float value =
        controls[c] > range.minimum ? (controls[c] < range.maximum ? controls[c] : range.maximum) : range.minimum;
    state.places[c] = (value - range.minimum) / range.length;
  }
}

void ExactBlend::find_weights(const float* controls, std::size_t pose, State& state) const {
  if (empty()) return;
  find_places(controls, state);
  Weight* const weights = state.weights.data() + pose * falloffs_.size();
  std::uint32_t found = 0;
  float sum = 0;
  for (std::uint32_t e = 0; e < falloffs_.size(); ++e) {
    const float weight =
        exact_weight(state.places.data(), places_.data() + e * controls_.size(), controls_.size(), falloffs_[e]);
    if (weight == 0) continue;
    weights[found++] = {e, weight};
    sum += weight;
  }
  state.found[pose] = found;
  if (sum > 1)
    for (std::uint32_t i = 0; i < found; ++i) weights[i].weight /= sum;
}

void ExactBlend::write_weights(std::size_t pose, const State& state, float* to) const {
  if (!to) return;
  std::fill_n(to, count(), 0.0f);
  for (const Weight& one : weights(pose, state)) to[one.pose] = one.weight;
}

void ExactBlend::find_weight_derivatives(const float* controls, State& state, float* derivatives) const {
  const std::size_t count = controls_.size();
  std::fill_n(derivatives, falloffs_.size() * count, 0.0f);
  find_places(controls, state);
  float sum = 0;
  Weight* const weights = state.weights.data();
  std::uint32_t found = 0;
  for (std::uint32_t e = 0; e < falloffs_.size(); ++e) {
    const float* const places = places_.data() + e * count;
    const float weight = exact_weight(state.places.data(), places, count, falloffs_[e]);
    if (weight == 0) continue;
    weights[found++] = {e, weight};
    sum += weight;
    float squares = 0;
    for (std::size_t c = 0; c < count; ++c) squares += (state.places[c] - places[c]) * (state.places[c] - places[c]);
    const float slope = -4.0f * (1.0f - squares * falloffs_[e]) * falloffs_[e];
    for (std::size_t c = 0; c < count; ++c)
      if (controls[c] >= controls_[c].minimum && controls[c] <= controls_[c].maximum && controls_[c].length > 0)
        derivatives[e * count + c] = slope * (state.places[c] - places[c]) / controls_[c].length;
  }
  if (!(sum > 1)) return;
  for (std::size_t c = 0; c < count; ++c) {  // of weight / sum
    float of_sum = 0;
    for (std::uint32_t i = 0; i < found; ++i) of_sum += derivatives[weights[i].pose * count + c];
    for (std::uint32_t i = 0; i < found; ++i) {
      float& derivative = derivatives[weights[i].pose * count + c];
      derivative = (derivative - weights[i].weight / sum * of_sum) / sum;
    }
  }
}

bool ExactBlend::add(std::size_t block, std::span<const Weight> weights, float* rows) const {
  bool any = false;
  for (const Weight& one : weights) {
    const std::size_t start = starts_[one.pose * row_counts_.size() + block];
    if (start == none) continue;
    any = true;
    const float* const values = values_.data() + start;
    for (std::uint32_t row = 0; row < row_counts_[block]; ++row) rows[row] += one.weight * values[row];
  }
  return any;
}

}  // namespace fb::runtime
