// Floats become whole numbers of one step, so that what is made of them is exact.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <vector>

#include "runtime/kernels/panel_kernels.h"

namespace fb {

// Numbers of one pose, or of each of a block. Pose p's lie at values + p * stride. Lists have room up to the next
// multiple of padding.
struct PoseNumbers {
  float* values;
  std::size_t stride, count;
  std::uint32_t* places;  // the column number i belongs to; null: column i
};

// Up to `longest` numbers of each of up to `poses` poses, ready to be multiplied with the columns of a matrix.
class Quantized {
 public:
  Quantized(std::size_t longest, std::size_t poses, std::pmr::memory_resource& memory);

  // FORMAT.md, "Whole numbers", of x, whose room is filled up; columns not named are 0. `limit` is the largest input.
  // `poses`: 1 or block_poses. Returns whether any input is not 0. x's places are referred to until the next time.
  bool quantize(const PoseKernels& kernels, const PoseNumbers& x, float limit, std::size_t poses);

  // An input times step() is about the number it stands for; 0 if all numbers of the pose are.
  float step(std::size_t pose) const { return steps_[pose]; }
  // `ahead`: see ActiveColumns.
  ActiveColumns columns(const std::uint8_t* ahead = nullptr) const {
    return {places_, inputs_, count_, poses_, starts_, ahead};
  }

 private:
  void list_what_counts();

  std::pmr::vector<std::int16_t> wholes_, kept_inputs_;
  std::pmr::vector<std::uint32_t> in_order_, kept_places_;  // in_order_: 0, 1, 2, ...
  const std::uint32_t* places_ = nullptr;
  const std::int16_t* inputs_ = nullptr;
  std::size_t count_ = 0, poses_ = 1;
  std::uint32_t starts_[block_poses] = {};
  float steps_[block_poses] = {};
};

}  // namespace fb
