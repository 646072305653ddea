#include "runtime/error_prediction.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace fb::runtime {
namespace {

constexpr std::size_t pair_word_bits = 64;

}  // namespace

ErrorPrediction::State::State(const ErrorPrediction& prediction, std::pmr::memory_resource& memory)
    : active(prediction.words_, &memory), moved(prediction.words_ > 0 ? prediction.controls_.size() : 0, &memory) {}

ErrorPrediction::ErrorPrediction(const PackedModel& model, std::span<const std::uint32_t> baked_index,
                                 std::pmr::memory_resource& memory)
    : controls_(&memory),
      weights_(&memory),
      constants_(&memory),
      shares_(&memory),
      untrained_pairs_(&memory),
      vertex_regions_(&memory) {
  const ExpectedErrors& from = model.expected;
  if (from.regions.empty()) return;
  const std::size_t controls = model.schema.control_count(), vertices = model.rest.surface_vertex_count();
  unit_ = from.unit;
  constants_.reserve(from.regions.size());
  for (const ExpectedErrors::Region& region : from.regions) constants_.push_back(region.constant);
  weights_.reserve(from.weights.size());
  for (const std::uint8_t code : from.weights) weights_.push_back(decoded_weight(code));
  controls_.reserve(controls);
  for (std::size_t c = 0; c < controls; ++c) {
    const Control& control = model.schema.controls[c];
    controls_.push_back({control.minimum, control.maximum, control.rest, control.reach(),
                         255 / (control.maximum - control.minimum), static_cast<float>(from.trained_low[c]),
                         static_cast<float>(from.trained_high[c])});
  }

  std::pmr::vector<std::uint32_t> sizes(from.regions.size(), &memory);
  std::pmr::vector<std::uint32_t> baked_regions(vertices, &memory);
  std::size_t vertex = 0;
  for (const ExpectedErrors::Run& run : from.runs) {
    std::fill_n(baked_regions.begin() + static_cast<std::ptrdiff_t>(vertex), run.vertices, run.region);
    vertex += run.vertices;
    sizes[run.region] += run.vertices;
  }
  for (const std::uint32_t size : sizes) shares_.push_back(static_cast<float>(size) / static_cast<float>(vertices));
  vertex_regions_.resize(vertices);
  for (std::size_t v = 0; v < vertices; ++v)
    vertex_regions_[v] = baked_regions[baked_index.empty() ? v : baked_index[v]];

  if (std::all_of(from.untrained_pairs.begin(), from.untrained_pairs.end(), [](auto byte) { return byte == 0; }))
    return;
  words_ = (controls + pair_word_bits - 1) / pair_word_bits;
  untrained_pairs_.resize(controls * words_);
  for (std::size_t b = 1; b < controls; ++b)
    for (std::size_t a = 0; a < b; ++a)
      if (from.is_untrained(a, b)) {
        untrained_pairs_[a * words_ + b / pair_word_bits] |= std::uint64_t(1) << b % pair_word_bits;
        untrained_pairs_[b * words_ + a / pair_word_bits] |= std::uint64_t(1) << a % pair_word_bits;
      }
}

void ErrorPrediction::run(const float* controls, float* errors, std::uint32_t* outside, State& state) const {
  const std::size_t regions = constants_.size();
  float squares[max_error_regions];
  std::copy_n(constants_.begin(), regions, squares);
  std::uint32_t count = 0;
  std::size_t moved = 0;
  std::fill(state.active.begin(), state.active.end(), 0);
  for (std::size_t c = 0; c < controls_.size(); ++c) {
    const ControlRange& range = controls_[c];
    const float value = std::min(std::max(controls[c], range.minimum), range.maximum);
    const float from_rest = value - range.rest;
    if (from_rest == 0) continue;
    float reached = std::fabs(from_rest) / range.reach;
    reached = reached < 1 ? reached : 1;
    const float effect = reached * std::sqrt(reached);
    const float* const weights = weights_.data() + c * regions;
    for (std::size_t r = 0; r < regions; ++r) squares[r] += effect * weights[r];
    const float place = (value - range.minimum) * range.steps;
    if (place < range.low || place > range.high)
      ++count;
    else if (words_ > 0 && reached >= together)
      state.moved[moved++] = static_cast<std::uint32_t>(c);
    if (words_ > 0 && reached >= together) state.active[c / pair_word_bits] |= std::uint64_t(1) << c % pair_word_bits;
  }
  for (std::size_t i = 0; i < moved; ++i) {
    const std::uint64_t* const untrained = untrained_pairs_.data() + state.moved[i] * words_;
    std::uint64_t any = 0;
    for (std::size_t w = 0; w < words_; ++w) any |= untrained[w] & state.active[w];
    if (any != 0) ++count;
  }
  if (outside) *outside = count;
  if (!errors) return;
  float mean = 0;
  for (std::size_t r = 0; r < regions; ++r) {
    mean += shares_[r] * squares[r];
    errors[1 + r] = unit_ * std::sqrt(squares[r]);
  }
  errors[0] = unit_ * std::sqrt(mean);
}

}  // namespace fb::runtime
