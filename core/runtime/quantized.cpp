#include "runtime/quantized.h"

#include <algorithm>
#include <cstring>
#include <numeric>

namespace fb {

Quantized::Quantized(std::size_t longest, std::size_t poses, std::pmr::memory_resource& memory)
    : wholes_(longest + padding, &memory),
      places_(longest + padding, &memory),
      in_order_(longest + padding, &memory),
      inputs_(poses * (longest + padding), &memory) {
  std::iota(in_order_.begin(), in_order_.end(), 0u);
}

bool Quantized::quantize(const PoseKernels& kernels, const PoseNumbers& x, float limit, std::size_t poses) {
  poses_ = poses;
  count_ = (x.count + 3) / 4 * 4;
  std::int32_t* wholes = wholes_.data();
  bool any = false;
  for (std::size_t pose = 0; pose < poses; ++pose) {
    steps_[pose] = kernels.round_all(x.values + pose * x.stride, x.count, limit, wholes);
    if (steps_[pose] == 0) std::fill_n(wholes, count_, 0);
    any |= steps_[pose] != 0;
    std::uint32_t sum = 0;
    for (std::size_t i = 0; i < count_; ++i) sum += static_cast<std::uint32_t>(wholes[i]);
    starts_[pose] = 0 - 128 * sum;
    if (poses == 1) break;
    std::int16_t* to = inputs_.data() + 4 * pose;
    for (std::size_t i = 0; i < count_; i += 4, to += 4 * poses) {
      std::int16_t four[4];
      for (int k = 0; k < 4; ++k) four[k] = static_cast<std::int16_t>(wholes[i + k]);
      std::memcpy(to, four, sizeof four);
    }
  }
  if (!any) count_ = 0;
  if (poses == 1)
    list_one(x);
  else
    list_all(x);
  return any;
}

// Columns whose input is 0 are left out. Whether one is, is a coin toss no branch predictor wins, so they are written
// whether listed or not; but most often no number of four is 0, or some always is.
void Quantized::list_one(const PoseNumbers& x) {
  const std::uint32_t* places = x.places ? x.places : in_order_.data();
  const std::int32_t* wholes = wholes_.data();
  std::uint32_t* listed = places_.data();
  std::int16_t* inputs = inputs_.data();
  const std::size_t whole_fours = count_ == 0 ? 0 : x.count / 4 * 4, end = count_ == 0 ? 0 : x.count;
  std::size_t used = 0;
  const auto list = [&](std::size_t i) {
    listed[used] = places[i];
    inputs[used] = static_cast<std::int16_t>(wholes[i]);
    used += wholes[i] != 0;
  };
  for (std::size_t i = 0; i < whole_fours; i += 4) {
    if ((wholes[i] != 0) & (wholes[i + 1] != 0) & (wholes[i + 2] != 0) & (wholes[i + 3] != 0)) {
      std::memcpy(listed + used, places + i, 4 * sizeof *listed);
      for (int k = 0; k < 4; ++k) inputs[used + k] = static_cast<std::int16_t>(wholes[i + k]);
      used += 4;
    } else {
      for (int k = 0; k < 4; ++k) list(i + k);
    }
  }
  for (std::size_t i = whole_fours; i < end; ++i) list(i);
  for (; used % 4 != 0; ++used) {
    listed[used] = listed[0];
    inputs[used] = 0;
  }
  count_ = used;
  listed_ = listed;
}

void Quantized::list_all(const PoseNumbers& x) {
  std::uint32_t* listed = places_.data();
  if (count_ != 0) {
    std::copy_n(x.places ? x.places : in_order_.data(), x.count, listed);
    std::fill(listed + x.count, listed + count_, listed[0]);
  }
  listed_ = listed;
}

}  // namespace fb
