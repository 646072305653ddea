// Quantisation of the inputs of a matrix to integer multiples of one step, so that matrix products are exact.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <vector>

#include "runtime/kernels/pose_kernels.h"

namespace fb::runtime {

// The inputs of a matrix in 1 or poses_per_block poses. Every array has room up to the next multiple of `padding`.
struct MatrixInputs {
  float* values;
  std::size_t count;
  // 0: input i of pose p is values[i * poses + p]. Otherwise it is values[p * pose_stride + i].
  std::size_t pose_stride = 0;
  // PanelMatrix::offset of the column of each input; null: all columns, in order
  std::uint32_t* offsets = nullptr;
};

// Quantised inputs: an input is about its integer times the pose's step. Refers to the buffers it was made in.
struct QuantisedInputs {
  const std::uint32_t* offsets = nullptr;  // see MatrixInputs
  const std::int16_t* values = nullptr;    // in the order of PanelInputs::values
  std::size_t count = 0;                   // a multiple of 4; 0 if all inputs of all poses are 0
  std::size_t poses = 1;
  float steps[poses_per_block] = {};                 // by pose; 0 if all inputs of the pose are 0
  std::uint32_t initial_sums[poses_per_block] = {};  // see PanelInputs

  PanelInputs panel_inputs() const { return {offsets, values, count, poses, initial_sums}; }
};

// Buffers for the quantised inputs of one layer after the other.
class QuantiseBuffers {
 public:
  // For up to `count` inputs of each of up to `poses` poses.
  QuantiseBuffers(std::size_t count, std::size_t poses, std::pmr::memory_resource& memory)
      : row_(count + padding, &memory), values_(poses * (count + padding), &memory) {}
  std::int16_t* row() { return row_.data(); }        // of one pose
  std::int16_t* values() { return values_.data(); }  // of all poses

 private:
  std::pmr::vector<std::int16_t> row_, values_;
};

// EVALUATION.md, "Quantise". `limit`: the largest integer. `to` has room for `poses` times the padded count; `row` for
// the padded count of one pose, needed only for several poses with a pose stride. Writes to the padding of x.
void quantise(const PoseKernels& kernels, const MatrixInputs& x, float limit, std::size_t poses, std::int16_t* to,
              std::int16_t* row, QuantisedInputs& quantised);

}  // namespace fb::runtime
