#include <arm_neon.h>

#include "runtime/kernels/pose_kernels.h"

namespace fb::runtime {
namespace {

#include "runtime/kernels/float_kernels.h"

int8x16_t load(const std::uint8_t* bytes) {
  return vreinterpretq_s8_u8(veorq_u8(vld1q_u8(bytes), vdupq_n_u8(128)));
}

// Sums of 16 rows: four columns are interleaved to fours of bytes for the dot product instruction, once with the low
// and once with the high digits of four inputs. It takes signed bytes, so the offset of the digits is removed and
// initial_sums is not needed.
template <int rows, int poses>
void sum_columns(const std::uint8_t* digits, const PanelInputs& panel, std::size_t first_pose,
                 std::int32_t (&sums)[poses][rows]) {
  int32x4_t low_sum[poses][4], high_sum[poses][4];
  for (int p = 0; p < poses; ++p)
    for (int i = 0; i < 4; ++i) low_sum[p][i] = high_sum[p][i] = vdupq_n_s32(0);
  const std::int16_t* numbers = panel.values + 4 * first_pose;
  for (std::size_t k = 0; k < panel.count; k += 4, numbers += 4 * panel.poses) {
    const std::uint32_t* at = panel.offsets + k;
    const int8x16_t a = load(digits + at[0]), b = load(digits + at[1]);
    const int8x16_t c = load(digits + at[2]), d = load(digits + at[3]);
    const int16x8_t ab[2] = {vreinterpretq_s16_s8(vzip1q_s8(a, b)), vreinterpretq_s16_s8(vzip2q_s8(a, b))};
    const int16x8_t cd[2] = {vreinterpretq_s16_s8(vzip1q_s8(c, d)), vreinterpretq_s16_s8(vzip2q_s8(c, d))};
    const int8x16_t fours[4] = {
        vreinterpretq_s8_s16(vzip1q_s16(ab[0], cd[0])), vreinterpretq_s8_s16(vzip2q_s16(ab[0], cd[0])),
        vreinterpretq_s8_s16(vzip1q_s16(ab[1], cd[1])), vreinterpretq_s8_s16(vzip2q_s16(ab[1], cd[1]))};
    for (int p = 0; p < poses; ++p) {
      const int16x4_t inputs = vld1_s16(numbers + 4 * p);
      const int8x8_t bytes = vreinterpret_s8_s16(inputs);
      const int8x8_t carried = vreinterpret_s8_s16(vadd_s16(inputs, vdup_n_s16(128)));  // low digits are signed
      const int8x8_t low = vuzp1_s8(bytes, bytes), high = vuzp2_s8(carried, carried);
      for (int i = 0; i < 4; ++i) {
        low_sum[p][i] = vdotq_lane_s32(low_sum[p][i], fours[i], low, 0);
        high_sum[p][i] = vdotq_lane_s32(high_sum[p][i], fours[i], high, 0);
      }
    }
  }
  for (int p = 0; p < poses; ++p)
    for (int i = 0; i < 4; ++i) vst1q_s32(sums[p] + 4 * i, vaddq_s32(low_sum[p][i], vshlq_n_s32(high_sum[p][i], 8)));
}

// Sums of 16 rows: a vector holds four rows of a quad.
template <int rows, int poses>
void sum_quads(const std::uint8_t* quads, std::size_t stride, const PanelInputs& panel, std::size_t first_pose,
               std::int32_t (&sums)[poses][rows]) {
  static constexpr std::uint8_t low_digits[8] = {0, 4, 2, 6, 0, 4, 2, 6}, high_digits[8] = {1, 5, 3, 7, 1, 5, 3, 7};
  int32x4_t low_sum[poses][4], high_sum[poses][4];
  for (int p = 0; p < poses; ++p)
    for (int v = 0; v < 4; ++v) low_sum[p][v] = high_sum[p][v] = vdupq_n_s32(0);
  const std::int16_t* numbers = panel.values + 4 * first_pose;
  for (std::size_t k = 0; k < panel.count; k += 4, numbers += 4 * panel.poses, quads += stride) {
    const int8x16_t weights[4] = {load(quads), load(quads + 16), load(quads + 32), load(quads + 48)};
    for (int p = 0; p < poses; ++p) {
      const int16x4_t inputs = vld1_s16(numbers + 4 * p);
      const int8x8_t carried = vreinterpret_s8_s16(vadd_s16(inputs, vdup_n_s16(128)));  // low digits are signed
      const int8x8_t low = vtbl1_s8(vreinterpret_s8_s16(inputs), vreinterpret_s8_u8(vld1_u8(low_digits)));
      const int8x8_t high = vtbl1_s8(carried, vreinterpret_s8_u8(vld1_u8(high_digits)));
      for (int v = 0; v < 4; ++v) {
        low_sum[p][v] = vdotq_lane_s32(low_sum[p][v], weights[v], low, 0);
        high_sum[p][v] = vdotq_lane_s32(high_sum[p][v], weights[v], high, 0);
      }
    }
  }
  for (int p = 0; p < poses; ++p)
    for (int v = 0; v < 4; ++v) vst1q_s32(sums[p] + 4 * v, vaddq_s32(low_sum[p][v], vshlq_n_s32(high_sum[p][v], 8)));
}

#include "runtime/kernels/strips.h"

}  // namespace

const PoseKernels neon_dot_kernels = make_kernels("neon-dot", column_product<16, 16, 2>, quad_product<16, 16, 2>);

}  // namespace fb::runtime
