#include "runtime/derivative/feature_derivatives.h"

#include <algorithm>

namespace fb::runtime {
namespace {

// By the control, at an offset from rest, on the side `direction`.
float control_feature_derivative(const Feature& feature, float offset, float direction) {
  const float rate = feature.scale, motion = rate * direction;
  if (feature.kind == FeatureKind::identity) return direction != 0 ? rate : 0;
  const float t = (offset != 0 ? offset * rate : 0) - feature.threshold;
  if (motion == 0 || t < 0 || (t == 0 && motion < 0)) return 0;
  if (feature.kind == FeatureKind::ramp || t < 1 || (t == 1 && motion < 0)) return rate;
  const float falling = 1.0f + (1.0f - t) * feature.fall;
  return falling > 0 || (falling == 0 && motion < 0) ? -feature.fall * rate : 0;
}

}  // namespace

FeatureDerivatives::FeatureDerivatives(const FeatureGraph& graph, std::pmr::memory_resource& memory)
    : graph_(graph),
      state_(graph, 1, memory),
      directions_(graph.control_count(), &memory),
      offsets_(graph.control_count(), &memory),
      combined_(graph.combined(memory)),
      first_(&memory),
      controls_(&memory),
      derivatives_(&memory),
      operands_(&memory) {
  first_.reserve(graph.feature_count() + 1);
  first_.push_back(0);
  for (std::size_t f = 0; f < graph.control_feature_count(); ++f) {
    controls_.push_back(graph.control_feature_at(f).control);
    first_.push_back(static_cast<std::uint32_t>(controls_.size()));
  }
  for (const FeatureGraph::Combined& combined : combined_) add_combined(combined);
  derivatives_.resize(1 + controls_.size());
}

// Its controls are those of both operands.
void FeatureDerivatives::add_combined(const FeatureGraph::Combined& combined) {
  std::uint32_t a = first_[combined.first], b = first_[combined.second];
  const std::uint32_t a_end = first_[combined.first + 1], b_end = first_[combined.second + 1];
  while (a < a_end || b < b_end) {
    const std::uint32_t of_a = a < a_end ? controls_[a] : UINT32_MAX, of_b = b < b_end ? controls_[b] : UINT32_MAX;
    controls_.push_back(std::min(of_a, of_b));
    operands_.push_back({of_a <= of_b ? 1 + a++ : 0, of_b <= of_a ? 1 + b++ : 0});
  }
  first_.push_back(static_cast<std::uint32_t>(controls_.size()));
}

void FeatureDerivatives::run(const PoseKernels& kernels, const float* controls, const std::uint8_t* downwards) {
  graph_.run(kernels, controls, 0, 1, state_);
  for (std::size_t c = 0; c < directions_.size(); ++c) {
    const float least = graph_.minimum(c), most = graph_.maximum(c);
    const bool down = downwards && downwards[c] ? controls[c] > least : controls[c] >= most;
    directions_[c] = controls[c] < least || controls[c] > most || least == most ? 0.0f : down ? -1.0f : 1.0f;
    offsets_[c] = std::min(std::max(controls[c], least), most) - graph_.rest(c);
  }
  const std::size_t of_controls = graph_.control_feature_count();
  for (std::size_t f = 0; f < of_controls; ++f)
    derivatives_[1 + f] =
        control_feature_derivative(graph_.control_feature_at(f), offsets_[controls_[f]], directions_[controls_[f]]);
  const Operands* operands = operands_.data();
  for (const FeatureGraph::Combined& combined : combined_) {
    const float first = value(combined.first), second = value(combined.second);
    for (std::uint32_t i = first_[combined.index]; i < first_[combined.index + 1]; ++i, ++operands) {
      const float by_first = derivatives_[operands->first], by_second = derivatives_[operands->second];
      const float direction = directions_[controls_[i]];
      const float least = by_first * direction < by_second * direction ? by_first : by_second;
      derivatives_[1 + i] = combined.kind == Feature::Kind::product ? by_first * second + first * by_second
                            : first < second                        ? by_first
                            : second < first                        ? by_second
                                                                    : least;
    }
  }
}

}  // namespace fb::runtime
