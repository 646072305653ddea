#include "runtime/quantized.h"

#include <algorithm>
#include <cstring>

namespace fb::runtime {
namespace {

bool set(Quantized& quantized, std::size_t pose, const Rounded& rounded) {
  quantized.steps[pose] = rounded.step;
  quantized.starts[pose] = 0 - 128 * rounded.sum;
  return rounded.step != 0;
}

}  // namespace

bool quantize(const PoseKernels& kernels, const PoseNumbers& x, float limit, std::size_t poses, std::int16_t* quantised,
              Quantized& quantized) {
  bool any = false;
  if (poses == 1) {
    any = set(quantized, 0, kernels.quantise_all(x.values, x.count, limit, quantised));
  } else {
    Rounded rounded[block_poses];
    kernels.round_block(x.values, x.count, limit, quantised, rounded);
    for (std::size_t pose = 0; pose < block_poses; ++pose) any |= set(quantized, pose, rounded[pose]);
  }
  const std::size_t count = any ? (x.count + 3) / 4 * 4 : 0;
  for (std::size_t i = x.count; i < count; ++i) x.places[i] = x.places[0];
  quantized.places = x.places;
  quantized.inputs = quantised;
  quantized.count = count;
  quantized.poses = poses;
  return any;
}

LayerInputs::LayerInputs(std::size_t longest, std::size_t poses, std::pmr::memory_resource& memory)
    : row_(longest + padding, &memory), quantised_(poses * (longest + padding), &memory) {}

const Quantized& LayerInputs::quantize(const PoseKernels& kernels, const PoseRows& x, float limit, std::size_t poses) {
  bool any = false;
  if (poses == 1) {
    any = set(quantized_, 0, kernels.quantise_all(x.values, x.count, limit, quantised_.data()));
  } else {
    for (std::size_t pose = 0; pose < block_poses; ++pose) {
      const Rounded rounded = kernels.quantise_all(x.values + pose * x.stride, x.count, limit, row_.data());
      if (!set(quantized_, pose, rounded)) std::fill_n(row_.begin(), x.count + padding, std::int16_t(0));
      any |= rounded.step != 0;
      std::int16_t* to = quantised_.data() + 4 * pose;
      for (std::size_t i = 0; i < x.count; i += 4, to += 4 * block_poses)
        std::memcpy(to, row_.data() + i, 4 * sizeof(std::int16_t));
    }
  }
  quantized_.inputs = quantised_.data();
  quantized_.count = any ? (x.count + 3) / 4 * 4 : 0;
  quantized_.poses = poses;
  return quantized_;
}

}  // namespace fb::runtime
