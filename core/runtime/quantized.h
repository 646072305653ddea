// Floats become whole numbers of one step, so that what is made of them is exact.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <vector>

#include "runtime/kernels/panel_kernels.h"

namespace fb {

// A list of numbers of one pose, or of each pose of a block, side by side: number i of pose p lies at values[i * poses
// + p]. There is room up to the next multiple of padding.
struct PoseNumbers {
  float* values;
  std::size_t count;
  std::uint32_t* places;  // the column number i belongs to
};

// What a layer gives to the next: pose p's numbers lie at values + p * stride, with room as above.
struct PoseRows {
  float* values;
  std::size_t stride, count;
};

// Up to `longest` numbers of each of up to `poses` poses, ready to be multiplied with the columns of a matrix.
class Quantized {
 public:
  Quantized(std::size_t longest, std::size_t poses, std::pmr::memory_resource& memory);

  // FORMAT.md, "Whole numbers", of x, whose room is filled up; columns not named are 0. `limit` is the largest input.
  // `poses`: 1 or block_poses. Returns whether any input is not 0. x's places are referred to until the next time.
  bool quantize(const PoseKernels& kernels, const PoseNumbers& x, float limit, std::size_t poses);
  // The same of rows, whose number i belongs to column i.
  bool quantize(const PoseKernels& kernels, const PoseRows& x, float limit, std::size_t poses);

  // An input times step() is about the number it stands for; 0 if all numbers of the pose are.
  float step(std::size_t pose) const { return steps_[pose]; }
  // `ahead`: see ActiveColumns.
  ActiveColumns columns(const std::uint8_t* ahead = nullptr) const {
    return {places_, inputs_, count_, poses_, starts_, ahead};
  }

 private:
  // Places are null where number i belongs to column i.
  bool quantize_one(const PoseKernels& kernels, const PoseNumbers& x, float limit);
  bool use_block(const Rounded (&rounded)[block_poses], std::uint32_t* places, std::size_t count);
  void fill_up(std::uint32_t* places, std::size_t count);
  void list_what_counts(const std::uint32_t* places, std::size_t count);

  std::pmr::vector<std::int16_t> wholes_, kept_inputs_;
  std::pmr::vector<std::uint32_t> in_order_, kept_places_;  // in_order_: 0, 1, 2, ...
  const std::uint32_t* places_ = nullptr;
  const std::int16_t* inputs_ = nullptr;
  std::size_t count_ = 0, poses_ = 1;
  std::uint32_t starts_[block_poses] = {};
  float steps_[block_poses] = {};
};

}  // namespace fb
