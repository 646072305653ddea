#include <arm_neon.h>

#include "runtime/kernels/panel_kernels.h"

namespace fb {
namespace {

#include "runtime/kernels/vector_passes.h"

// 16 rows at a time: four columns become fours of bytes, which one instruction multiplies and adds, with the low digits
// of the four inputs and again with the high ones. It takes signed bytes, so digits lose their offset first, and
// `start` with it.
void panel_sums(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::int32_t* sums) {
  const auto load = [](const std::uint8_t* bytes) {
    return vreinterpretq_s8_u8(veorq_u8(vld1q_u8(bytes), vdupq_n_u8(128)));
  };
  for (std::size_t r = 0; r < rows; r += 16) {
    int32x4_t low_sum[4], high_sum[4];
    for (int i = 0; i < 4; ++i) low_sum[i] = high_sum[i] = vdupq_n_s32(0);
    for (std::size_t k = 0; k < active.count; k += 4) {
      const std::uint32_t* place = active.places + k;
      const int8x16_t a = load(digits + place[0] * rows + r), b = load(digits + place[1] * rows + r);
      const int8x16_t c = load(digits + place[2] * rows + r), d = load(digits + place[3] * rows + r);
      const int16x4_t inputs = vld1_s16(active.inputs + k);
      const int8x8_t bytes = vreinterpret_s8_s16(inputs);
      const int8x8_t carried = vreinterpret_s8_s16(vadd_s16(inputs, vdup_n_s16(128)));  // low digits are signed
      const int8x8_t low = vuzp1_s8(bytes, bytes), high = vuzp2_s8(carried, carried);
      const int16x8_t ab[2] = {vreinterpretq_s16_s8(vzip1q_s8(a, b)), vreinterpretq_s16_s8(vzip2q_s8(a, b))};
      const int16x8_t cd[2] = {vreinterpretq_s16_s8(vzip1q_s8(c, d)), vreinterpretq_s16_s8(vzip2q_s8(c, d))};
      for (int i = 0; i < 2; ++i) {
        const int8x16_t first = vreinterpretq_s8_s16(vzip1q_s16(ab[i], cd[i]));
        const int8x16_t last = vreinterpretq_s8_s16(vzip2q_s16(ab[i], cd[i]));
        low_sum[2 * i] = vdotq_lane_s32(low_sum[2 * i], first, low, 0);
        high_sum[2 * i] = vdotq_lane_s32(high_sum[2 * i], first, high, 0);
        low_sum[2 * i + 1] = vdotq_lane_s32(low_sum[2 * i + 1], last, low, 0);
        high_sum[2 * i + 1] = vdotq_lane_s32(high_sum[2 * i + 1], last, high, 0);
      }
    }
    for (int i = 0; i < 4; ++i) vst1q_s32(sums + r + 4 * i, vaddq_s32(low_sum[i], vshlq_n_s32(high_sum[i], 8)));
  }
}

}  // namespace

const PoseKernels neon_dot_kernels = {"neon-dot", panel_sums, round_all, move_rows, finish_layer, to_halves, normalise};

}  // namespace fb
