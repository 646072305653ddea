#include <arm_neon.h>

#include "runtime/kernels/pose_kernels.h"

namespace fb::runtime {
namespace {

#include "runtime/kernels/float_kernels.h"

// Sums of 16 rows, one column at a time: digits + 128 fit signed 16-bit numbers.
template <int rows, int poses>
void sum_columns(const std::uint8_t* digits, const PanelInputs& panel, std::size_t first_pose,
                 std::int32_t (&sums)[poses][rows]) {
  int32x4_t sum[poses][4];
  for (int p = 0; p < poses; ++p)
    for (int32x4_t& s : sum[p]) s = vreinterpretq_s32_u32(vdupq_n_u32(panel.initial_sums[first_pose + p]));
  const std::int16_t* inputs = panel.values + 4 * first_pose;
  for (std::size_t k = 0; k < panel.count; k += 4, inputs += 4 * panel.poses)
    for (int i = 0; i < 4; ++i) {
      const uint8x16_t column = vld1q_u8(digits + panel.offsets[k + i]);
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
    for (int i = 0; i < 4; ++i) vst1q_s32(sums[p] + 4 * i, sum[p][i]);
}

// Sums of 16 rows: four vectors of a quad. The sums of a row's columns are added pairwise at the end.
template <int rows, int poses>
void sum_quads(const std::uint8_t* quads, std::size_t stride, const PanelInputs& panel, std::size_t first_pose,
               std::int32_t (&sums)[poses][rows]) {
  int32x4_t sum[poses][8];
  for (int p = 0; p < poses; ++p)
    for (int32x4_t& s : sum[p]) s = vdupq_n_s32(0);
  const std::int16_t* inputs = panel.values + 4 * first_pose;
  for (std::size_t k = 0; k < panel.count; k += 4, inputs += 4 * panel.poses, quads += stride)
    for (int v = 0; v < 4; ++v) {
      const uint16x8_t weights = vreinterpretq_u16_u8(vld1q_u8(quads + 16 * v));
      const int16x8_t first = vreinterpretq_s16_u16(vandq_u16(weights, vdupq_n_u16(255)));
      const int16x8_t last = vreinterpretq_s16_u16(vshrq_n_u16(weights, 8));
      for (int p = 0; p < poses; ++p) {
        const int32x2_t four = vreinterpret_s32_s16(vld1_s16(inputs + 4 * p));
        const int16x4_t x = vreinterpret_s16_s32(vdup_lane_s32(four, 0));
        const int16x4_t y = vreinterpret_s16_s32(vdup_lane_s32(four, 1));
        int32x4_t* const s = sum[p] + 2 * v;
        s[0] = vmlal_s16(vmlal_s16(s[0], vget_low_s16(first), x), vget_low_s16(last), y);
        s[1] = vmlal_s16(vmlal_s16(s[1], vget_high_s16(first), x), vget_high_s16(last), y);
      }
    }
  for (int p = 0; p < poses; ++p) {
    const int32x4_t start = vreinterpretq_s32_u32(vdupq_n_u32(panel.initial_sums[first_pose + p]));
    for (int v = 0; v < 4; ++v)
      vst1q_s32(sums[p] + 4 * v, vaddq_s32(start, vpaddq_s32(sum[p][2 * v], sum[p][2 * v + 1])));
  }
}

#include "runtime/kernels/strips.h"

}  // namespace

const PoseKernels neon_kernels = make_kernels("neon", column_product<16, 16, 4>, quad_product<16, 16, 2>);

}  // namespace fb::runtime
