#include "runtime/feature_graph.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <type_traits>

#include "base/checked.h"
#include "model/feature_values.h"
#include "runtime/grouped.h"

namespace fb {

FeatureState::FeatureState(const FeatureGraph& graph, std::pmr::memory_resource& memory)
    : values_(graph.feature_count() * block_poses, &memory),
      active_(graph.feature_count() + 1, &memory),
      moved_controls_(graph.control_count() + 1, &memory),
      is_active_(graph.feature_count(), &memory),
      candidates_(graph.feature_count() + 1, &memory),
      controls_(graph.control_count() * block_poses, &memory),
      is_moved_(graph.control_count(), &memory) {}

FeatureGraph::FeatureGraph(const PackedModel& model, std::pmr::memory_resource& memory)
    : feature_count_(model.features.size()),
      minimum_(&memory),
      maximum_(&memory),
      rest_(&memory),
      of_controls_(&memory),
      control_begin_(&memory),
      combined_(&memory),
      combined_begin_(&memory),
      other_(&memory),
      restless_(&memory),
      restless_begin_(&memory) {
  for (std::pmr::vector<float>* ends : {&minimum_, &maximum_, &rest_}) ends->reserve(model.schema.control_count());
  for (const Control& c : model.schema.controls) {
    minimum_.push_back(c.minimum);
    maximum_.push_back(c.maximum);
    rest_.push_back(c.rest);
  }
  std::vector<std::uint32_t> level(feature_count_, 0);
  std::vector<char> signed_(feature_count_, 0);  // may be below 0, or not a number
  Grouped<ControlFeature> by_control(rest_.size());
  Grouped<Combined> by_feature(feature_count_), by_level(0);
  std::uint32_t deepest = 0;
  for (std::uint32_t f = 0; f < feature_count_; ++f) {
    const Feature& feature = model.features[f];
    if (!feature.of_features()) {
      by_control.add(feature.control, {feature, f});
      for (const float end : {minimum_[feature.control], maximum_[feature.control]})
        if (!(control_feature(feature, end, rest_[feature.control]) >= 0)) signed_[f] = 1;
      continue;
    }
    const auto [first, second] = std::pair(feature.first, feature.second);
    level[f] = 1 + std::max(level[first], level[second]);
    deepest = std::max(deepest, level[f]);
    signed_[f] = signed_[first] || signed_[second];
    const Combined combined = {f, first, second, feature.kind};
    if (feature.kind == Feature::Kind::minimum && signed_[f])
      by_level.add(level[f], combined);
    else
      by_feature.add(level[first] >= level[second] ? first : second, combined);
  }
  by_level.widen(std::size_t(deepest) + 1);
  by_control.move_to(of_controls_, control_begin_);
  by_feature.move_to(combined_, combined_begin_);
  other_.reserve(combined_.size());
  for (std::uint32_t f = 0; f < feature_count_; ++f)
    for (std::uint32_t c = combined_begin_[f]; c < combined_begin_[f + 1]; ++c)
      other_.push_back(combined_[c].first == f ? combined_[c].second : combined_[c].first);
  by_level.move_to(restless_, restless_begin_);
}

namespace {

// Of one pose, or of four of a block.
template <std::size_t poses>
using Number = std::conditional_t<poses == 1, float, FourFloats>;

template <std::size_t poses>
Number<poses> load(const float* from) {
  Number<poses> number;
  std::memcpy(&number, from, sizeof number);
  return number;
}

bool any_of(FourMasks masks) {
  const auto halves = std::bit_cast<std::array<std::uint64_t, 2>>(masks);
  return (halves[0] | halves[1]) != 0;
}

}  // namespace

[[gnu::noinline]] std::uint64_t FeatureGraph::clamp(const float* __restrict controls, float* __restrict within,
                                                    std::uint32_t* __restrict is_moved) const {
  std::uint32_t clamped = 0;
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    const float low = controls[i] < minimum_[i] ? minimum_[i] : controls[i];
    within[i] = low > maximum_[i] ? maximum_[i] : low;
    clamped += within[i] != controls[i];
    is_moved[i] |= within[i] != rest_[i];
  }
  return clamped;
}

template <std::size_t poses>
std::uint64_t FeatureGraph::run_poses(const float* controls, std::size_t stride, FeatureState& state) const {
  float* values = state.values_.data();
  std::uint32_t* active = state.active_.data();
  std::uint8_t* is_active = state.is_active_.data();

  std::uint64_t clamped = 0;
  std::fill(state.is_moved_.begin(), state.is_moved_.end(), 0u);
  for (std::size_t p = 0; p < poses; ++p)
    clamped += clamp(controls + p * stride, state.controls_.data() + p * control_count(), state.is_moved_.data());
  std::size_t moved = 0;
  std::uint32_t* moved_controls = state.moved_controls_.data();
  for (std::size_t i = 0; i < control_count(); ++i) {
    moved_controls[moved] = static_cast<std::uint32_t>(i);
    moved += state.is_moved_[i];
  }

  // What is looked at lies here and there, so it is asked for some steps ahead.
  constexpr std::size_t ahead = 8;
  const std::uint32_t* begin = combined_begin_.data();

  // Listed whether 0 or not, and then not counted: that is a coin toss no branch predictor wins.
  std::size_t count = 0;
  FourMasks moved_counts = {};
  const auto set = [&](std::uint32_t feature, auto&& value) {
    __builtin_prefetch(begin + feature);
    active[count] = feature;
    if constexpr (poses == 1) {
      values[feature] = value(0);
      count += is_active[feature] = values[feature] != 0;
    } else {
      FourMasks any = {};
      for (std::size_t p = 0; p < poses; p += 4) {
        const FourFloats four = value(p);
        std::memcpy(values + feature * poses + p, &four, sizeof four);
        const FourMasks is_moved = four != 0.0f;
        moved_counts -= is_moved;
        any |= is_moved;
      }
      count += is_active[feature] = any_of(any);
    }
  };
  const ControlFeature* of_controls = of_controls_.data();
  for (std::size_t m = 0; m < moved; ++m) {
    const std::uint32_t control = moved_controls[m];
    if (m + ahead < moved) __builtin_prefetch(of_controls + control_begin_[moved_controls[m + ahead]]);
    const float rest = rest_[control];
    float within[poses];
    for (std::size_t p = 0; p < poses; ++p) within[p] = state.controls_[p * control_count() + control];
    const std::uint32_t end = control_begin_[control + 1];
    for (std::uint32_t f = control_begin_[control]; f < end; ++f)
      set(of_controls[f].index, [&, feature = of_controls[f].feature](std::size_t p) {
        return control_feature(feature, load<poses>(within + p), rest);
      });
  }
  // Level after level: what is listed under the features of one level is of the next.
  const auto combine = [&](const Combined& c) {
    set(c.index, [&, first = values + c.first * poses, second = values + c.second * poses](std::size_t p) {
      return combined_feature(c.kind, load<poses>(first + p), load<poses>(second + p));
    });
  };
  const Combined* combined = combined_.data();
  const std::uint32_t* other = other_.data();
  std::uint32_t* candidates = state.candidates_.data();
  std::size_t done = 0;
  for (std::size_t level = 1; level + 1 < restless_begin_.size(); ++level) {
    const std::size_t end = count;
    std::size_t candidate_count = 0;
    for (; done < end; ++done) {
      if (done + ahead < end) __builtin_prefetch(other + begin[active[done + ahead]]);
      const std::uint32_t last = begin[active[done] + 1];
      for (std::uint32_t c = begin[active[done]]; c < last; ++c) {
        candidates[candidate_count] = c;
        candidate_count += is_active[other[c]];
      }
    }
    for (std::size_t i = 0; i < candidate_count; ++i) combine(combined[candidates[i]]);
    for (std::uint32_t c = restless_begin_[level]; c < restless_begin_[level + 1]; ++c) combine(restless_[c]);
  }
  state.count_ = count;
  state.moved_count_ = poses == 1 ? count : 0;
  for (int i = 0; i < 4; ++i) state.moved_count_ += static_cast<std::uint32_t>(moved_counts[i]);
  return clamped;
}

std::uint64_t FeatureGraph::run(const float* controls, std::size_t stride, std::size_t poses,
                                FeatureState& state) const {
  if (state.poses_ == 1)
    for (const std::uint32_t feature : state.active()) state.values_[feature] = 0;
  else
    for (const std::uint32_t feature : state.active())
      std::fill_n(state.values_.data() + feature * block_poses, block_poses, 0.0f);
  for (const std::uint32_t feature : state.active()) state.is_active_[feature] = 0;
  state.poses_ = poses;
  return poses == 1 ? run_poses<1>(controls, stride, state) : run_poses<block_poses>(controls, stride, state);
}

}  // namespace fb
