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
  poses_ = poses;
  count_ = (x.count + 3) / 4 * 4;
  places_ = x.places ? x.places : in_order_.data();
  inputs_ = poses == 1 ? wholes_.data() : kept_inputs_.data();
  bool any = false;
  std::size_t zeros = 0;
  for (std::size_t pose = 0; pose < poses; ++pose) {
    const Rounded rounded = kernels.round_all(x.values + pose * x.stride, x.count, limit, wholes_.data());
    steps_[pose] = rounded.step;
    starts_[pose] = 0 - 128 * rounded.sum;
    zeros = rounded.zeros;
    any |= rounded.step != 0;
    if (poses == 1) break;
    if (rounded.step == 0) std::fill_n(wholes_.begin(), count_, std::int16_t(0));
    std::int16_t* to = kept_inputs_.data() + 4 * pose;
    for (std::size_t i = 0; i < count_; i += 4, to += 4 * poses)
      std::memcpy(to, wholes_.data() + i, 4 * sizeof(std::int16_t));
  }
  if (!any) {
    count_ = 0;
    return false;
  }
  if (poses == 1 && 8 * zeros > x.count) {
    list_what_counts();
  } else if (count_ > x.count) {
    std::uint32_t* const places = x.places ? x.places : kept_places_.data();
    if (!x.places) std::iota(places, places + x.count, 0u);
    std::fill(places + x.count, places + count_, places[0]);
    places_ = places;
  }
  return true;
}

// Columns whose input is 0 are left out. Whether one is, is a coin toss no branch predictor wins, so they are written
// whether listed or not.
void Quantized::list_what_counts() {
  std::size_t used = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    kept_places_[used] = places_[i];
    kept_inputs_[used] = inputs_[i];
    used += inputs_[i] != 0;
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
