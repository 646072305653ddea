#include <arm_neon.h>

#include "runtime/kernels/panel_kernels.h"

namespace fb {
namespace {

#include "runtime/kernels/vector_passes.h"

// 16 rows at a time, a column after the other: digits + 128 fit 16 signed bits.
void panel_sums(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::int32_t* sums) {
  for (std::size_t r = 0; r < rows; r += 16) {
    int32x4_t sum[4];
    for (int32x4_t& s : sum) s = vreinterpretq_s32_u32(vdupq_n_u32(active.start));
    for (std::size_t k = 0; k < active.count; ++k) {
      const uint8x16_t column = vld1q_u8(digits + active.places[k] * rows + r);
      const int16x8_t first = vreinterpretq_s16_u16(vmovl_u8(vget_low_u8(column)));
      const int16x8_t last = vreinterpretq_s16_u16(vmovl_u8(vget_high_u8(column)));
      const std::int16_t input = active.inputs[k];
      sum[0] = vmlal_n_s16(sum[0], vget_low_s16(first), input);
      sum[1] = vmlal_n_s16(sum[1], vget_high_s16(first), input);
      sum[2] = vmlal_n_s16(sum[2], vget_low_s16(last), input);
      sum[3] = vmlal_n_s16(sum[3], vget_high_s16(last), input);
    }
    for (int i = 0; i < 4; ++i) vst1q_s32(sums + r + 4 * i, sum[i]);
  }
}

}  // namespace

const PoseKernels neon_kernels = {"neon", panel_sums, round_all, move_rows, finish_layer, to_halves, normalise};

}  // namespace fb
