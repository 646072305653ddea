#include "runtime/feature_graph.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "base/checked.h"
#include "model/feature_values.h"
#include "runtime/grouped.h"

namespace fb::runtime {

FeatureState::FeatureState(const FeatureGraph& graph, std::pmr::memory_resource& memory)
    : values_(graph.feature_count() * block_poses, &memory),
      active_(graph.feature_count() + 16, &memory),
      candidates_(graph.feature_count() + 1, &memory),
      moves_(graph.control_count() * block_poses, &memory) {}

FeatureGraph::FeatureGraph(const PackedModel& model, std::pmr::memory_resource& memory)
    : numbers_(model.features.size(), &memory),
      minimum_(&memory),
      maximum_(&memory),
      rest_(&memory),
      controls_(&memory),
      kinds_(&memory),
      scales_(&memory),
      thresholds_(&memory),
      falls_(&memory),
      combined_(&memory),
      combined_begin_(&memory),
      other_(&memory),
      always_(&memory),
      always_begin_(&memory) {
  for (std::pmr::vector<float>* ends : {&minimum_, &maximum_, &rest_}) ends->reserve(model.schema.control_count());
  for (const Control& c : model.schema.controls) {
    minimum_.push_back(c.minimum);
    maximum_.push_back(c.maximum);
    rest_.push_back(c.rest);
  }

  std::vector<std::uint32_t> of_controls;
  for (std::uint32_t f = 0; f < model.features.size(); ++f)
    if (!model.features[f].of_features()) of_controls.push_back(f);
  std::stable_sort(of_controls.begin(), of_controls.end(), [&](std::uint32_t a, std::uint32_t b) {
    return model.features[a].control < model.features[b].control;
  });
  for (std::pmr::vector<float>* numbers : {&scales_, &thresholds_, &falls_}) numbers->reserve(of_controls.size());
  controls_.reserve(of_controls.size());
  kinds_.reserve(of_controls.size());
  for (const std::uint32_t f : of_controls) {
    const Feature& feature = model.features[f];
    numbers_[f] = static_cast<std::uint32_t>(controls_.size());
    controls_.push_back(feature.control);
    kinds_.push_back(feature.kind);
    scales_.push_back(feature.scale);
    thresholds_.push_back(feature.threshold);
    falls_.push_back(feature.fall);
  }

  std::vector<std::uint32_t> level(feature_count(), 0);
  std::vector<char> signed_(feature_count(), 0);  // may be below 0, or not a number
  Grouped<Combined> by_feature(feature_count()), by_level(0);
  std::uint32_t deepest = 0, next = static_cast<std::uint32_t>(of_controls.size());
  for (std::uint32_t f = 0; f < feature_count(); ++f) {
    const Feature& feature = model.features[f];
    if (!feature.of_features()) {
      for (const float end : {minimum_[feature.control], maximum_[feature.control]})
        if (!(control_feature(feature, end, rest_[feature.control]) >= 0)) signed_[f] = 1;
      continue;
    }
    numbers_[f] = next++;
    const auto [first, second] = std::pair(feature.first, feature.second);
    level[f] = 1 + std::max(level[first], level[second]);
    deepest = std::max(deepest, level[f]);
    signed_[f] = signed_[first] || signed_[second];
    const Combined combined = {numbers_[f], numbers_[first], numbers_[second], feature.kind};
    if (feature.kind == Feature::Kind::minimum && signed_[f])
      by_level.add(level[f], combined);
    else
      by_feature.add(numbers_[level[first] >= level[second] ? first : second], combined);
  }
  by_level.widen(std::size_t(deepest) + 1);
  by_feature.move_to(combined_, combined_begin_);
  other_.reserve(combined_.size());
  for (std::uint32_t f = 0; f < feature_count(); ++f)
    for (std::uint32_t c = combined_begin_[f]; c < combined_begin_[f + 1]; ++c)
      other_.push_back(combined_[c].first == f ? combined_[c].second : combined_[c].first);
  by_level.move_to(always_, always_begin_);
}

namespace {

FourFloats load_four(const float* from) {
  FourFloats four;
  std::memcpy(&four, from, sizeof four);
  return four;
}

// Minus how many of a feature's values are not 0: of one pose, or in each of four lanes those of poses four apart.
template <std::size_t poses>
auto moved(const float* values) {
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

template <std::size_t poses>
std::uint64_t FeatureGraph::run_poses(const PoseKernels& kernels, const float* controls, std::size_t stride,
                                      FeatureState& state) const {
  float* const values = state.values_.data();
  std::uint32_t* const active = state.active_.data();
  std::uint64_t clamped = 0;
  for (std::size_t p = 0; p < poses; ++p)
    clamped += kernels.clamp_controls(controls + p * stride, minimum_.data(), maximum_.data(), rest_.data(),
                                      control_count(), state.moves_.data() + p, poses);
  kernels.control_features(
      {controls_.data(), kinds_.data(), scales_.data(), thresholds_.data(), falls_.data(), controls_.size()},
      state.moves_.data(), poses, values);

  // Listed whether 0 or not, and then not counted: that is a coin toss no branch predictor wins.
  std::size_t count = 0;
  decltype(moved<poses>(values)) moved_counts = {};
  const auto list = [&](std::uint32_t feature) {
    const auto is_moved = moved<poses>(values + feature * poses);
    active[count] = feature;
    count += any_of(is_moved);
    moved_counts += is_moved;
  };
  if constexpr (poses == 1) {
    count = kernels.compact_nonzeros(values, controls_.size(), active);
    moved_counts = -static_cast<std::int32_t>(count);
  } else {
    for (std::uint32_t f = 0; f < controls_.size(); ++f) list(f);
  }
  state.of_controls_ = count;
  // Level after level: what is listed under the features of one level is of the next.
  const auto combine = [&](const Combined& c) {
    if constexpr (poses == 1) {  // neither is 0, or it is a minimum of any two
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
    list(c.index);
  };
  // What is looked at lies here and there, so it is asked for some steps ahead.
  constexpr std::size_t ahead = 8;
  const std::uint32_t *const begin = combined_begin_.data(), *const other = other_.data();
  std::uint32_t* const candidates = state.candidates_.data();
  std::size_t done = 0;
  for (std::size_t level = 1; level + 1 < always_begin_.size(); ++level) {
    const std::size_t end = count;
    std::size_t candidate_count = 0;
    for (; done < end; ++done) {
      if (done + ahead < end) __builtin_prefetch(other + begin[active[done + ahead]]);
      const std::uint32_t last = begin[active[done] + 1];
      for (std::uint32_t c = begin[active[done]]; c < last; ++c) {
        candidates[candidate_count] = c;
        candidate_count += any_of(moved<poses>(values + other[c] * poses));
      }
    }
    for (std::size_t i = 0; i < candidate_count; ++i) combine(combined_[candidates[i]]);
    for (std::uint32_t c = always_begin_[level]; c < always_begin_[level + 1]; ++c) combine(always_[c]);
  }
  state.count_ = count;
  state.moved_count_ = total(moved_counts);
  return clamped;
}

std::uint64_t FeatureGraph::run(const PoseKernels& kernels, const float* controls, std::size_t stride,
                                std::size_t poses, FeatureState& state) const {
  for (const std::uint32_t feature : state.active().subspan(state.of_controls_))
    if (state.poses_ == 1)
      state.values_[feature] = 0;
    else
      std::fill_n(state.values_.data() + feature * block_poses, block_poses, 0.0f);
  if (state.poses_ != poses) std::fill_n(state.values_.data(), controls_.size() * state.poses_, 0.0f);
  state.poses_ = poses;
  return poses == 1 ? run_poses<1>(kernels, controls, stride, state)
                    : run_poses<block_poses>(kernels, controls, stride, state);
}

}  // namespace fb::runtime
