#include <arm_neon.h>

#include "runtime/kernels/panel_kernels.h"

namespace fb {
namespace {

#include "runtime/kernels/vector_passes.h"

// 16 rows of some poses, a column after the other: digits + 128 fit 16 signed bits.
template <int poses>
void add_up(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::size_t first_pose,
            std::int32_t* sums) {
  int32x4_t sum[poses][4];
  for (int p = 0; p < poses; ++p)
    for (int32x4_t& s : sum[p]) s = vreinterpretq_s32_u32(vdupq_n_u32(active.start[first_pose + p]));
  const std::int16_t* inputs = active.inputs + 4 * first_pose;
  for (std::size_t k = 0; k < active.count; k += 4, inputs += 4 * active.poses)
    for (int i = 0; i < 4; ++i) {
      const uint8x16_t column = vld1q_u8(digits + active.places[k + i] * rows);
      const int16x8_t first = vreinterpretq_s16_u16(vmovl_u8(vget_low_u8(column)));
      const int16x8_t last = vreinterpretq_s16_u16(vmovl_u8(vget_high_u8(column)));
      for (int p = 0; p < poses; ++p) {
        const std::int16_t input = inputs[4 * p + i];
        sum[p][0] = vmlal_n_s16(sum[p][0], vget_low_s16(first), input);
        sum[p][1] = vmlal_n_s16(sum[p][1], vget_high_s16(first), input);
        sum[p][2] = vmlal_n_s16(sum[p][2], vget_low_s16(last), input);
        sum[p][3] = vmlal_n_s16(sum[p][3], vget_high_s16(last), input);
      }
    }
  for (int p = 0; p < poses; ++p)
    for (int i = 0; i < 4; ++i) vst1q_s32(sums + panel_rows * (first_pose + p) + 4 * i, sum[p][i]);
}

void panel_sums(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::int32_t* sums) {
  for (std::size_t r = 0; r < rows; r += 16)
    if (active.poses == 1)
      add_up<1>(digits + r, rows, active, 0, sums + r);
    else
      for (std::size_t pose = 0; pose < block_poses; pose += 4) add_up<4>(digits + r, rows, active, pose, sums + r);
}

}  // namespace

const PoseKernels neon_kernels = {"neon",    panel_sums,   round_all, round_block,
                                  move_rows, finish_layer, to_halves, normalise};

}  // namespace fb
