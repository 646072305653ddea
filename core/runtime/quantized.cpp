#include "runtime/quantized.h"

#include <algorithm>
#include <cstring>
#include <numeric>

namespace fb {

Quantized::Quantized(std::size_t longest, std::size_t poses, std::pmr::memory_resource& memory)
    : wholes_(longest + padding, &memory),
      kept_inputs_(poses * (longest + padding), &memory),
      in_order_(longest + padding, &memory),
      kept_places_(longest + padding, &memory) {
  std::iota(in_order_.begin(), in_order_.end(), 0u);
}

bool Quantized::quantize(const PoseKernels& kernels, const PoseNumbers& x, float limit, std::size_t poses) {
  if (poses == 1) return quantize_one(kernels, x, limit);
  Rounded rounded[block_poses];
  kernels.round_block(x.values, x.count, limit, kept_inputs_.data(), rounded);
  return use_block(rounded, x.places, x.count);
}

bool Quantized::quantize(const PoseKernels& kernels, const PoseRows& x, float limit, std::size_t poses) {
  if (poses == 1) return quantize_one(kernels, {x.values, x.count, nullptr}, limit);
  Rounded rounded[block_poses];
  for (std::size_t pose = 0; pose < block_poses; ++pose) {
    rounded[pose] = kernels.round_all(x.values + pose * x.stride, x.count, limit, wholes_.data());
    if (rounded[pose].step == 0) std::fill_n(wholes_.begin(), x.count + padding, std::int16_t(0));
    std::int16_t* to = kept_inputs_.data() + 4 * pose;
    for (std::size_t i = 0; i < x.count; i += 4, to += 4 * block_poses)
      std::memcpy(to, wholes_.data() + i, 4 * sizeof(std::int16_t));
  }
  return use_block(rounded, nullptr, x.count);
}

bool Quantized::quantize_one(const PoseKernels& kernels, const PoseNumbers& x, float limit) {
  const Rounded rounded = kernels.round_all(x.values, x.count, limit, wholes_.data());
  inputs_ = wholes_.data();
  poses_ = 1;
  steps_[0] = rounded.step;
  starts_[0] = 0 - 128 * rounded.sum;
  count_ = 0;
  if (rounded.step == 0) return false;
  if (8 * rounded.zeros > x.count)
    list_what_counts(x.places ? x.places : in_order_.data(), x.count);
  else
    fill_up(x.places, x.count);
  return true;
}

bool Quantized::use_block(const Rounded (&rounded)[block_poses], std::uint32_t* places, std::size_t count) {
  inputs_ = kept_inputs_.data();
  poses_ = block_poses;
  bool any = false;
  for (std::size_t pose = 0; pose < block_poses; ++pose) {
    steps_[pose] = rounded[pose].step;
    starts_[pose] = 0 - 128 * rounded[pose].sum;
    any |= rounded[pose].step != 0;
  }
  count_ = 0;
  if (any) fill_up(places, count);
  return any;
}

void Quantized::fill_up(std::uint32_t* places, std::size_t count) {
  count_ = (count + 3) / 4 * 4;
  places_ = places ? places : in_order_.data();
  if (count_ == count) return;
  if (!places) {
    places = kept_places_.data();
    std::iota(places, places + count, 0u);
  }
  std::fill(places + count, places + count_, places[0]);
  places_ = places;
}

// Columns whose input is 0 are left out. Whether one is, is a coin toss no branch predictor wins, so they are written
// whether listed or not.
void Quantized::list_what_counts(const std::uint32_t* places, std::size_t count) {
  std::size_t used = 0;
  for (std::size_t i = 0; i < count; ++i) {
    kept_places_[used] = places[i];
    kept_inputs_[used] = wholes_[i];
    used += wholes_[i] != 0;
  }
  for (; used % 4 != 0; ++used) {
    kept_places_[used] = kept_places_[0];
    kept_inputs_[used] = 0;
  }
  count_ = used;
  places_ = kept_places_.data();
  inputs_ = kept_inputs_.data();
}

}  // namespace fb
