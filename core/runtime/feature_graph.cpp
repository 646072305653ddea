#include "runtime/feature_graph.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "base/checked.h"
#include "model/feature_values.h"

namespace fb::runtime {

FeatureState::FeatureState(const FeatureGraph& graph, std::size_t poses, std::pmr::memory_resource& memory)
    : values_(graph.feature_count() * poses, &memory),
      active_(graph.feature_count() + 16, &memory),
      candidates_(graph.feature_count() + 1, &memory),
      offsets_(graph.control_count() * poses, &memory) {}

FeatureGraph::FeatureGraph(const PackedModel& model, std::pmr::memory_resource& memory, std::pmr::memory_resource& heap)
    : graph_index_(model.features.size(), &memory),
      minimum_(&memory),
      maximum_(&memory),
      rest_(&memory),
      controls_(&memory),
      kinds_(&memory),
      scales_(&memory),
      thresholds_(&memory),
      falls_(&memory),
      combined_(memory),
      other_operand_(&memory),
      always_evaluated_(memory) {
  for (std::pmr::vector<float>* values : {&minimum_, &maximum_, &rest_}) values->reserve(model.schema.control_count());
  for (const Control& c : model.schema.controls) {
    minimum_.push_back(c.minimum);
    maximum_.push_back(c.maximum);
    rest_.push_back(c.rest);
  }
  add_control_features(model, heap);
  add_combined_features(model, heap);
}

void FeatureGraph::add_control_features(const PackedModel& model, std::pmr::memory_resource& heap) {
  std::pmr::vector<std::uint32_t> of_controls(&heap);
  of_controls.reserve(model.features.size());
  for (std::uint32_t f = 0; f < model.features.size(); ++f)
    if (!model.features[f].of_features()) of_controls.push_back(f);
  std::sort(of_controls.begin(), of_controls.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(model.features[a].control, a) < std::pair(model.features[b].control, b);
  });
  for (std::pmr::vector<float>* numbers : {&scales_, &thresholds_, &falls_}) numbers->reserve(of_controls.size());
  controls_.reserve(of_controls.size());
  kinds_.reserve(of_controls.size());
  for (const std::uint32_t f : of_controls) {
    const Feature& feature = model.features[f];
    graph_index_[f] = static_cast<std::uint32_t>(controls_.size());
    controls_.push_back(feature.control);
    kinds_.push_back(feature.kind);
    scales_.push_back(feature.scale);
    thresholds_.push_back(feature.threshold);
    falls_.push_back(feature.fall);
  }
}

void FeatureGraph::add_combined_features(const PackedModel& model, std::pmr::memory_resource& heap) {
  std::pmr::vector<std::uint32_t> level(feature_count(), 0, &heap);
  std::pmr::vector<char> may_be_negative(feature_count(), 0, &heap);  // or NaN
  std::uint32_t next = static_cast<std::uint32_t>(controls_.size()), deepest = 0;
  for (std::uint32_t f = 0; f < feature_count(); ++f) {
    const Feature& feature = model.features[f];
    if (feature.of_features()) {
      graph_index_[f] = next++;
      level[f] = 1 + std::max(level[feature.first], level[feature.second]);
      deepest = std::max(deepest, level[f]);
      may_be_negative[f] = may_be_negative[feature.first] || may_be_negative[feature.second];
    } else {
      for (const float end : {minimum_[feature.control], maximum_[feature.control]})
        if (!(control_feature(feature, end, rest_[feature.control]) >= 0)) may_be_negative[f] = 1;
    }
  }
  CsrBuilder<Combined> by_operand(feature_count(), feature_count() - controls_.size(), heap),
      by_level(std::size_t(deepest) + 1, 0, heap);
  for (std::uint32_t f = 0; f < feature_count(); ++f) {
    const Feature& feature = model.features[f];
    if (!feature.of_features()) continue;
    const std::uint32_t first = feature.first, second = feature.second;
    const Combined combined = {graph_index_[f], graph_index_[first], graph_index_[second], feature.kind};
    if (feature.kind == Feature::Kind::minimum && may_be_negative[f])
      by_level.add(level[f], combined);
    else
      by_operand.add(graph_index_[level[first] >= level[second] ? first : second], combined);
  }
  by_operand.build(combined_);
  other_operand_.reserve(combined_.entries.size());
  for (std::uint32_t f = 0; f < feature_count(); ++f)
    for (const Combined& c : combined_.row(f)) other_operand_.push_back(c.first == f ? c.second : c.first);
  by_level.build(always_evaluated_);
}

std::pmr::vector<FeatureGraph::Combined> FeatureGraph::combined(std::pmr::memory_resource& memory) const {
  std::pmr::vector<Combined> all(combined_.entries.begin(), combined_.entries.end(), &memory);
  all.insert(all.end(), always_evaluated_.entries.begin(), always_evaluated_.entries.end());
  std::sort(all.begin(), all.end(), [](const Combined& a, const Combined& b) { return a.index < b.index; });
  return all;
}

namespace {

FourFloats load_four(const float* from) {
  FourFloats four;
  std::memcpy(&four, from, sizeof four);
  return four;
}

// Minus the number of a feature's values that are not 0: of one pose, or by lane of every fourth pose.
template <std::size_t poses>
auto nonzero_mask(const float* values) {
  if constexpr (poses == 1) {
    return -std::int32_t((std::bit_cast<std::uint32_t>(*values) & 0x7fffffff) != 0);
  } else {
    FourMasks masks = {};
    for (std::size_t p = 0; p < poses; p += 4) masks += load_four(values + p) != 0.0f;
    return masks;
  }
}

bool any_of(std::int32_t mask) {
  return mask != 0;
}
bool any_of(FourMasks masks) {
  const auto halves = std::bit_cast<std::array<std::uint64_t, 2>>(masks);
  return (halves[0] | halves[1]) != 0;
}

std::size_t total(std::int32_t masks) {
  return static_cast<std::size_t>(-masks);
}
std::size_t total(FourMasks masks) {
  return static_cast<std::size_t>(-(masks[0] + masks[1] + masks[2] + masks[3]));
}

}  // namespace

// Collects the indices of active features. An index is always written, but counted only if the feature is active: a
// branch would be unpredictable.
template <std::size_t poses>
class FeatureGraph::ActiveList {
 public:
  ActiveList(const float* values, std::uint32_t* indices) : values_(values), indices_(indices) {}
  void append_if_active(std::uint32_t feature) {
    const auto mask = nonzero_mask<poses>(values_ + feature * poses);
    indices_[count] = feature;
    count += any_of(mask);
    masks += mask;
  }

  std::size_t count = 0;
  decltype(nonzero_mask<poses>(nullptr)) masks = {};  // the sum over all features

 private:
  const float* values_;
  std::uint32_t* indices_;
};

template <std::size_t poses>
void FeatureGraph::run_combined(FeatureState& state, ActiveList<poses>& active) const {
  float* const values = state.values_.data();
  const auto evaluate = [&](const Combined& c) {
    if constexpr (poses == 1) {  // both operands are active, or it is a minimum
      const float first = values[c.first], second = values[c.second];
      const float least = first < second ? first : second, product = first * second;
      values[c.index] = c.kind == Feature::Kind::minimum ? least : product;
    } else {
      for (std::size_t p = 0; p < poses; p += 4) {
        const FourFloats value =
            combined_feature(c.kind, load_four(values + c.first * poses + p), load_four(values + c.second * poses + p));
        std::memcpy(values + c.index * poses + p, &value, sizeof value);
      }
    }
    active.append_if_active(c.index);
  };
  constexpr std::size_t prefetch_distance = 8;  // in active features
  const std::uint32_t* const begin = combined_.row_offsets.data();
  const std::uint32_t* const other = other_operand_.data();
  const std::uint32_t* const indices = state.active_.data();
  std::uint32_t* const candidates = state.candidates_.data();
  std::size_t done = 0;
  // The rows of the active features of one level list features of the next.
  for (std::size_t level = 1; level + 1 < always_evaluated_.row_offsets.size(); ++level) {
    const std::size_t end = active.count;
    std::size_t candidate_count = 0;
    for (; done < end; ++done) {
      if (done + prefetch_distance < end) __builtin_prefetch(other + begin[indices[done + prefetch_distance]]);
      const std::uint32_t last = begin[indices[done] + 1];
      for (std::uint32_t c = begin[indices[done]]; c < last; ++c) {
        candidates[candidate_count] = c;
        candidate_count += any_of(nonzero_mask<poses>(values + other[c] * poses));
      }
    }
    for (std::size_t i = 0; i < candidate_count; ++i) evaluate(combined_.entries[candidates[i]]);
    for (const Combined& c : always_evaluated_.row(level)) evaluate(c);
  }
}

template <std::size_t poses>
std::uint64_t FeatureGraph::run_poses(const PoseKernels& kernels, const float* controls, std::size_t stride,
                                      FeatureState& state) const {
  std::uint64_t clamped = 0;
  for (std::size_t p = 0; p < poses; ++p)
    clamped += kernels.clamp_controls(controls + p * stride, minimum_.data(), maximum_.data(), rest_.data(),
                                      control_count(), state.offsets_.data() + p, poses);
  kernels.control_features(
      {controls_.data(), kinds_.data(), scales_.data(), thresholds_.data(), falls_.data(), controls_.size()},
      state.offsets_.data(), poses, state.values_.data());
  ActiveList<poses> active(state.values_.data(), state.active_.data());
  if constexpr (poses == 1) {
    active.count = kernels.compact_nonzeros(state.values_.data(), controls_.size(), state.active_.data());
    active.masks = -static_cast<std::int32_t>(active.count);
  } else {
    for (std::uint32_t f = 0; f < controls_.size(); ++f) active.append_if_active(f);
  }
  state.active_control_features_ = active.count;
  run_combined(state, active);
  state.active_count_ = active.count;
  state.nonzero_count_ = total(active.masks);
  return clamped;
}

std::uint64_t FeatureGraph::run(const PoseKernels& kernels, const float* controls, std::size_t stride,
                                std::size_t poses, FeatureState& state) const {
  // Combined features of the previous run are reset; features of controls are all computed.
  for (const std::uint32_t feature : state.active().subspan(state.active_control_features_))
    if (state.poses_ == 1)
      state.values_[feature] = 0;
    else
      std::fill_n(state.values_.data() + feature * poses_per_block, poses_per_block, 0.0f);
  if (state.poses_ != poses) std::fill_n(state.values_.data(), controls_.size() * state.poses_, 0.0f);
  state.poses_ = poses;
  return poses == 1 ? run_poses<1>(kernels, controls, stride, state)
                    : run_poses<poses_per_block>(kernels, controls, stride, state);
}

}  // namespace fb::runtime
