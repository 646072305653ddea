#include "runtime/quantise.h"

#include <algorithm>
#include <cstring>

namespace fb::runtime {
namespace {

// Returns whether any input of the pose is not 0.
bool set_pose(QuantisedInputs& quantised, std::size_t pose, const Quantisation& result) {
  quantised.steps[pose] = result.step;
  quantised.initial_sums[pose] = 0 - 128 * result.sum;
  return result.step != 0;
}

// Poses one after the other become fours of inputs of every pose.
bool quantise_rows(const PoseKernels& kernels, const MatrixInputs& x, float limit, std::int16_t* to, std::int16_t* row,
                   QuantisedInputs& quantised) {
  bool any = false;
  for (std::size_t pose = 0; pose < poses_per_block; ++pose) {
    const Quantisation result = kernels.quantise(x.values + pose * x.pose_stride, x.count, limit, row);
    if (!set_pose(quantised, pose, result)) std::fill_n(row, x.count + padding, std::int16_t(0));
    any |= result.step != 0;
    std::int16_t* fours = to + 4 * pose;
    for (std::size_t i = 0; i < x.count; i += 4, fours += 4 * poses_per_block)
      std::memcpy(fours, row + i, 4 * sizeof(std::int16_t));
  }
  return any;
}

}  // namespace

void quantise(const PoseKernels& kernels, const MatrixInputs& x, float limit, std::size_t poses, std::int16_t* to,
              std::int16_t* row, QuantisedInputs& quantised) {
  bool any = false;
  if (poses == 1) {
    any = set_pose(quantised, 0, kernels.quantise(x.values, x.count, limit, to));
  } else if (x.pose_stride == 0) {
    Quantisation results[poses_per_block];
    kernels.quantise_block(x.values, x.count, limit, to, results);
    for (std::size_t pose = 0; pose < poses_per_block; ++pose) any |= set_pose(quantised, pose, results[pose]);
  } else {
    any = quantise_rows(kernels, x, limit, to, row, quantised);
  }
  quantised.count = any ? (x.count + 3) / 4 * 4 : 0;
  if (x.offsets)
    for (std::size_t i = x.count; i < quantised.count; ++i) x.offsets[i] = x.offsets[0];
  quantised.offsets = x.offsets;
  quantised.values = to;
  quantised.poses = poses;
}

}  // namespace fb::runtime
