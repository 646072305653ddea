#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "model/packed_model.h"

namespace fb::runtime {

// Expected errors of poses, see ExpectedErrors. core/archive/EVALUATION.md defines every operation.
class ErrorPrediction {
 public:
  ErrorPrediction(const PackedModel& model, std::span<const std::uint32_t> baked_index,
                  std::pmr::memory_resource& memory);

  // Floats of a pose: the whole face, then each region; 0 if errors are not known.
  std::size_t count() const { return constants_.empty() ? 0 : constants_.size() + 1; }
  // By vertex in source order: its region.
  std::span<const std::uint32_t> vertex_regions() const { return vertex_regions_; }

  // Working memory of a thread.
  struct State {
    State(const ErrorPrediction& prediction, std::pmr::memory_resource& memory);
    std::pmr::vector<std::uint64_t> active;  // by control, a bit
    std::pmr::vector<std::uint32_t> moved;   // controls
  };

  // controls: of one pose, none NaN. Writes count() floats to `errors`, in the model's units, unless it is null, and to
  // `outside`, unless it is null, how many controls are outside of what was trained.
  void run(const float* controls, float* errors, std::uint32_t* outside, State& state) const;

 private:
  struct ControlRange {
    float minimum, maximum, rest, reach;
    float steps, low, high;  // 255 / (maximum - minimum); trained values
  };

  std::pmr::vector<ControlRange> controls_;
  std::pmr::vector<float> weights_;                  // controls x regions
  std::pmr::vector<float> constants_, shares_;       // by region
  std::pmr::vector<std::uint64_t> untrained_pairs_;  // controls x words: a bit for each other control
  std::pmr::vector<std::uint32_t> vertex_regions_;
  std::size_t words_ = 0;
  float unit_ = 0;
};

}  // namespace fb::runtime
