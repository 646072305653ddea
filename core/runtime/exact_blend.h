#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "model/packed_model.h"

namespace fb::runtime {

// Adds the corrections of exact poses to positions, see ExactPose. core/archive/EVALUATION.md defines every operation.
class ExactBlend {
 public:
  ExactBlend(const PackedModel& model, std::pmr::memory_resource& memory);

  bool empty() const { return falloffs_.empty(); }

  struct Weight {
    std::uint32_t pose;
    float weight;
  };
  // Working memory of a worker, for a block of so many poses.
  struct State {
    State(const ExactBlend& blend, std::size_t poses, std::pmr::memory_resource& memory);
    std::pmr::vector<float> places;         // of controls in their ranges
    std::pmr::vector<Weight> weights;       // by pose of the block: room for all
    std::pmr::vector<std::uint32_t> found;  // by pose of the block: weights above 0
  };

  // Finds the weights of pose number `pose` of a block from its controls, none of which is NaN.
  void find_weights(const float* controls, std::size_t pose, State& state) const;
  std::span<const Weight> weights(std::size_t pose, const State& state) const {
    return state.found.empty() ? std::span<const Weight>()
                               : std::span(state.weights).subspan(pose * falloffs_.size(), state.found[pose]);
  }

  std::size_t count() const { return falloffs_.size(); }
  // Writes the weights of all exact poses for pose number `pose` of a block, unless `to` is null.
  void write_weights(std::size_t pose, const State& state, float* to) const;
  // Writes the derivatives of the weights by the controls, those of an exact pose after those of another. Those of a
  // control outside of its range are 0.
  void find_weight_derivatives(const float* controls, State& state, float* derivatives) const;
  // The correction of a row of a row block by an exact pose of weight 1.
  float correction(std::uint32_t pose, std::size_t block, std::uint32_t row) const {
    const std::size_t start = starts_[pose * row_counts_.size() + block];
    return start == none ? 0 : values_[start + row];
  }

  // Whether any correction of a row block by an exact pose is not 0.
  bool corrects(std::uint32_t pose, std::size_t block) const {
    return starts_[pose * row_counts_.size() + block] != none;
  }

  // Adds weighted corrections to the rows of a row block. Returns whether there are any.
  bool add(std::size_t block, std::span<const Weight> weights, float* rows) const;

 private:
  static constexpr std::size_t none = SIZE_MAX;

  void find_places(const float* controls, State& state) const;

  struct ControlRange {
    float minimum, length, maximum;
  };

  std::pmr::vector<ControlRange> controls_;
  std::pmr::vector<float> falloffs_;      // by exact pose
  std::pmr::vector<float> places_;        // exact poses x controls
  std::pmr::vector<std::size_t> starts_;  // exact poses x row blocks: in values_, or none where there is no correction
  std::pmr::vector<std::uint32_t> row_counts_;  // by row block
  std::pmr::vector<float> values_;
};

}  // namespace fb::runtime
