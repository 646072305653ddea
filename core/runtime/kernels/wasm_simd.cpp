#include <wasm_simd128.h>

#include "runtime/kernels/panel_kernels.h"

namespace fb {
namespace {

#include "runtime/kernels/vector_passes.h"

// 16 rows of some poses: two columns become pairs of 16-bit numbers, which one instruction multiplies and adds.
template <int poses>
void add_up(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::size_t first_pose,
            std::int32_t* sums) {
  v128_t sum[poses][4];
  for (int p = 0; p < poses; ++p)
    for (v128_t& s : sum[p]) s = wasm_i32x4_splat(static_cast<std::int32_t>(active.start[first_pose + p]));
  const std::int16_t* inputs = active.inputs + 4 * first_pose;
  for (std::size_t k = 0; k < active.count; k += 4, inputs += 4 * active.poses)
    for (int pair = 0; pair < 4; pair += 2) {
      const v128_t a = wasm_v128_load(digits + active.places[k + pair] * rows);
      const v128_t b = wasm_v128_load(digits + active.places[k + pair + 1] * rows);
      const v128_t first = wasm_i8x16_shuffle(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
      const v128_t last = wasm_i8x16_shuffle(a, b, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
      const v128_t weights[4] = {wasm_u16x8_extend_low_u8x16(first), wasm_u16x8_extend_high_u8x16(first),
                                 wasm_u16x8_extend_low_u8x16(last), wasm_u16x8_extend_high_u8x16(last)};
      for (int p = 0; p < poses; ++p) {
        const v128_t input = wasm_v128_load32_splat(inputs + 4 * p + pair);
        for (int i = 0; i < 4; ++i) sum[p][i] = wasm_i32x4_add(sum[p][i], wasm_i32x4_dot_i16x8(weights[i], input));
      }
    }
  for (int p = 0; p < poses; ++p)
    for (int i = 0; i < 4; ++i) wasm_v128_store(sums + panel_rows * (first_pose + p) + 4 * i, sum[p][i]);
}

void panel_sums(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::int32_t* sums) {
  for (std::size_t r = 0; r < rows; r += 16)
    if (active.poses == 1)
      add_up<1>(digits + r, rows, active, 0, sums + r);
    else
      for (std::size_t pose = 0; pose < block_poses; pose += 2) add_up<2>(digits + r, rows, active, pose, sums + r);
}

}  // namespace

const PoseKernels wasm_simd_kernels = {"wasm-simd", panel_sums,   round_all, round_block,
                                       move_rows,   finish_layer, to_halves, normalise};

}  // namespace fb
