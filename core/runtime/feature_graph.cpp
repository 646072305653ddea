#include "runtime/feature_graph.h"

#include <algorithm>

#include "base/checked.h"
#include "model/feature_values.h"
#include "runtime/grouped.h"

namespace fb {

FeatureState::FeatureState(const FeatureGraph& graph, std::pmr::memory_resource& memory)
    : values_(graph.feature_count(), &memory),
      active_(graph.feature_count() + 1, &memory),
      moved_controls_(graph.control_count() + 1, &memory),
      moved_values_(graph.control_count() + 1, &memory) {}

FeatureGraph::FeatureGraph(const PackedModel& model, std::pmr::memory_resource& memory)
    : feature_count_(model.features.size()),
      ranges_(&memory),
      of_controls_(&memory),
      control_begin_(&memory),
      combined_(&memory),
      combined_begin_(&memory),
      restless_(&memory),
      restless_begin_(&memory) {
  ranges_.reserve(model.schema.control_count());
  for (const Control& c : model.schema.controls) ranges_.push_back({c.minimum, c.maximum, c.rest});
  std::vector<std::uint32_t> level(feature_count_, 0);
  std::vector<char> signed_(feature_count_, 0);  // may be below 0, or not a number
  Grouped<ControlFeature> by_control(ranges_.size());
  Grouped<Combined> by_feature(feature_count_), by_level(0);
  std::uint32_t deepest = 0;
  for (std::uint32_t f = 0; f < feature_count_; ++f) {
    const Feature& feature = model.features[f];
    if (!feature.of_features()) {
      const Range& range = ranges_[feature.control];
      by_control.add(feature.control, {feature, f});
      for (const float end : {range.minimum, range.maximum})
        if (!(control_feature(feature, end, range.rest) >= 0)) signed_[f] = 1;
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
  by_level.move_to(restless_, restless_begin_);
}

std::uint64_t FeatureGraph::run(const float* controls, FeatureState& state) const {
  float* values = state.values_.data();
  std::uint32_t* active = state.active_.data();
  for (std::size_t i = 0; i < state.count_; ++i) values[active[i]] = 0;

  std::uint64_t clamped = 0;
  std::size_t moved = 0;
  std::uint32_t* moved_controls = state.moved_controls_.data();
  float* moved_values = state.moved_values_.data();
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    const Range& range = ranges_[i];
    const float low = controls[i] < range.minimum ? range.minimum : controls[i];
    const float within = low > range.maximum ? range.maximum : low;
    clamped += within != controls[i];
    moved_controls[moved] = static_cast<std::uint32_t>(i);
    moved_values[moved] = within;
    moved += within != range.rest;
  }

  // Listed whether 0 or not, and then not counted: that is a coin toss no branch predictor wins.
  std::size_t count = 0;
  const auto set = [&](std::uint32_t feature, float value) {
    values[feature] = value;
    active[count] = feature;
    count += value != 0;
  };
  const ControlFeature* of_controls = of_controls_.data();
  for (std::size_t m = 0; m < moved; ++m) {
    const std::uint32_t control = moved_controls[m];
    for (std::uint32_t f = control_begin_[control]; f < control_begin_[control + 1]; ++f)
      set(of_controls[f].index, control_feature(of_controls[f].feature, moved_values[m], ranges_[control].rest));
  }
  // Level after level: what is listed under the features of one level is of the next.
  const auto combine = [&](const Combined& c) {
    set(c.index, combined_feature(c.kind, values[c.first], values[c.second]));
  };
  const Combined* combined = combined_.data();
  const std::uint32_t* begin = combined_begin_.data();
  std::size_t done = 0;
  for (std::size_t level = 1; level + 1 < restless_begin_.size(); ++level) {
    const std::size_t end = count;
    for (; done < end; ++done)
      for (std::uint32_t c = begin[active[done]]; c < begin[active[done] + 1]; ++c) combine(combined[c]);
    for (std::uint32_t c = restless_begin_[level]; c < restless_begin_[level + 1]; ++c) combine(restless_[c]);
  }
  state.count_ = count;
  return clamped;
}

}  // namespace fb
