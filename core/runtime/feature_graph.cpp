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

inline void FeatureGraph::combine(const Combined& c, FeatureState& state) const {
  const float* values = state.values_.data();
  state.set(c.index, combined_feature(c.kind, values[c.first], values[c.second]));
}

std::uint64_t FeatureGraph::run(const float* controls, FeatureState& state) const {
  for (const std::uint32_t feature : state.active()) state.values_[feature] = 0;
  state.count_ = 0;
  std::uint64_t clamped = 0;
  std::size_t moved = 0;
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    const Range& range = ranges_[i];
    const float low = controls[i] < range.minimum ? range.minimum : controls[i];
    const float within = low > range.maximum ? range.maximum : low;
    clamped += within != controls[i];
    state.moved_controls_[moved] = static_cast<std::uint32_t>(i);
    state.moved_values_[moved] = within;
    moved += within != range.rest;
  }
  for (std::size_t m = 0; m < moved; ++m) {
    const std::uint32_t control = state.moved_controls_[m];
    for (std::uint32_t f = control_begin_[control]; f < control_begin_[control + 1]; ++f)
      state.set(of_controls_[f].index,
                control_feature(of_controls_[f].feature, state.moved_values_[m], ranges_[control].rest));
  }
  // Level after level: what is listed under the features of one level is of the next.
  std::size_t done = 0;
  for (std::size_t level = 1; level + 1 < restless_begin_.size(); ++level) {
    const std::size_t end = state.count_;
    for (; done < end; ++done) {
      const std::uint32_t feature = state.active_[done];
      for (std::uint32_t c = combined_begin_[feature]; c < combined_begin_[feature + 1]; ++c)
        combine(combined_[c], state);
    }
    for (std::uint32_t c = restless_begin_[level]; c < restless_begin_[level + 1]; ++c) combine(restless_[c], state);
  }
  return clamped;
}

}  // namespace fb
