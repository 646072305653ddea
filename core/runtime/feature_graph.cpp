#include "runtime/feature_graph.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "base/checked.h"
#include "model/feature_values.h"
#include "runtime/grouped.h"

namespace fb {

FeatureState::FeatureState(const FeatureGraph& graph, std::pmr::memory_resource& memory)
    : values_(graph.feature_count() * block_poses, &memory),
      active_(graph.feature_count() + 1, &memory),
      moved_controls_(graph.control_count() + 1, &memory),
      moved_values_((graph.control_count() + 1) * block_poses, &memory) {}

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

namespace {

// Of one pose, beside zeros, or of four.
template <std::size_t poses>
FourFloats load(const float* from) {
  if constexpr (poses == 1) return FourFloats{*from, 0, 0, 0};
  FourFloats four;
  std::memcpy(&four, from, sizeof four);
  return four;
}

template <std::size_t poses>
void store(float* to, FourFloats four) {
  std::memcpy(to, &four, poses == 1 ? sizeof(float) : sizeof four);
}

bool any_of(FourMasks masks) {
  const auto halves = std::bit_cast<std::array<std::uint64_t, 2>>(masks);
  return (halves[0] | halves[1]) != 0;
}

}  // namespace

template <std::size_t poses>
std::uint64_t FeatureGraph::run_poses(const float* controls, std::size_t stride, FeatureState& state) const {
  float* values = state.values_.data();
  std::uint32_t* active = state.active_.data();

  std::uint64_t clamped = 0;
  std::size_t moved = 0;
  std::uint32_t* moved_controls = state.moved_controls_.data();
  float* moved_values = state.moved_values_.data();
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    const Range& range = ranges_[i];
    moved_controls[moved] = static_cast<std::uint32_t>(i);
    bool any = false;
    for (std::size_t p = 0; p < poses; ++p) {
      const float control = controls[p * stride + i];
      const float low = control < range.minimum ? range.minimum : control;
      const float within = low > range.maximum ? range.maximum : low;
      clamped += within != control;
      moved_values[moved * poses + p] = within;
      any |= within != range.rest;
    }
    moved += any;
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
    FourMasks any = {};
    for (std::size_t p = 0; p < poses; p += 4) {
      const FourFloats four = value(p);
      store<poses>(values + feature * poses + p, four);
      const FourMasks is_moved = four != 0.0f;
      moved_counts -= is_moved;
      any |= is_moved;
    }
    count += poses == 1 ? any[0] != 0 : any_of(any);
  };
  const ControlFeature* of_controls = of_controls_.data();
  for (std::size_t m = 0; m < moved; ++m) {
    const std::uint32_t control = moved_controls[m];
    if (m + ahead < moved) __builtin_prefetch(of_controls + control_begin_[moved_controls[m + ahead]]);
    const float rest = ranges_[control].rest;
    for (std::uint32_t f = control_begin_[control]; f < control_begin_[control + 1]; ++f)
      set(of_controls[f].index, [&, feature = of_controls[f].feature](std::size_t p) {
        return control_feature(feature, load<poses>(moved_values + m * poses + p), rest);
      });
  }
  // Level after level: what is listed under the features of one level is of the next.
  const auto combine = [&](const Combined& c) {
    set(c.index, [&, first = values + c.first * poses, second = values + c.second * poses](std::size_t p) {
      return combined_feature(c.kind, load<poses>(first + p), load<poses>(second + p));
    });
  };
  const Combined* combined = combined_.data();
  std::size_t done = 0;
  for (std::size_t level = 1; level + 1 < restless_begin_.size(); ++level) {
    const std::size_t end = count;
    for (; done < end; ++done) {
      if (done + ahead < end) __builtin_prefetch(combined + begin[active[done + ahead]]);
      for (std::uint32_t c = begin[active[done]]; c < begin[active[done] + 1]; ++c) combine(combined[c]);
    }
    for (std::uint32_t c = restless_begin_[level]; c < restless_begin_[level + 1]; ++c) combine(restless_[c]);
  }
  state.count_ = count;
  state.moved_count_ = 0;
  for (int i = 0; i < 4; ++i) state.moved_count_ += static_cast<std::uint32_t>(moved_counts[i]);
  return clamped;
}

std::uint64_t FeatureGraph::run(const float* controls, std::size_t stride, std::size_t poses,
                                FeatureState& state) const {
  if (state.poses_ == 1)
    for (std::size_t i = 0; i < state.count_; ++i) state.values_[state.active_[i]] = 0;
  else
    for (std::size_t i = 0; i < state.count_; ++i)
      std::fill_n(state.values_.data() + state.active_[i] * block_poses, block_poses, 0.0f);
  state.poses_ = poses;
  return poses == 1 ? run_poses<1>(controls, stride, state) : run_poses<block_poses>(controls, stride, state);
}

}  // namespace fb
