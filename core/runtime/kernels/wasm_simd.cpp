#include <wasm_simd128.h>

#include "runtime/kernels/pose_kernels.h"

namespace fb::runtime {
namespace {

#include "runtime/kernels/float_kernels.h"

// Two columns are interleaved to pairs of 16-bit numbers for the dot product instruction.
template <int rows, int poses>
void sum_columns(const std::uint8_t* digits, const PanelInputs& panel, std::size_t first_pose,
                 std::int32_t (&sums)[poses][rows]) {
  constexpr int blocks = rows / 16;
  v128_t sum[poses][4 * blocks];
  for (int p = 0; p < poses; ++p)
    for (v128_t& s : sum[p]) s = wasm_i32x4_splat(static_cast<std::int32_t>(panel.initial_sums[first_pose + p]));
  const std::int16_t* inputs = panel.values + 4 * first_pose;
  for (std::size_t k = 0; k < panel.count; k += 4, inputs += 4 * panel.poses)
    for (int pair = 0; pair < 4; pair += 2) {
      const std::uint8_t* column_a = digits + panel.offsets[k + pair];
      const std::uint8_t* column_b = digits + panel.offsets[k + pair + 1];
      for (int block = 0; block < blocks; ++block) {
        const v128_t a = wasm_v128_load(column_a + 16 * block), b = wasm_v128_load(column_b + 16 * block);
        const v128_t first = wasm_i8x16_shuffle(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
        const v128_t last = wasm_i8x16_shuffle(a, b, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
        const v128_t weights[4] = {wasm_u16x8_extend_low_u8x16(first), wasm_u16x8_extend_high_u8x16(first),
                                   wasm_u16x8_extend_low_u8x16(last), wasm_u16x8_extend_high_u8x16(last)};
        for (int p = 0; p < poses; ++p) {
          const v128_t input = wasm_v128_load32_splat(inputs + 4 * p + pair);
          v128_t* s = sum[p] + 4 * block;
          for (int i = 0; i < 4; ++i) s[i] = wasm_i32x4_add(s[i], wasm_i32x4_dot_i16x8(weights[i], input));
        }
      }
    }
  for (int p = 0; p < poses; ++p)
    for (int i = 0; i < 4 * blocks; ++i) wasm_v128_store(sums[p] + 4 * i, sum[p][i]);
}

// Four rows of a quad are a vector.
template <int rows, int poses>
void sum_quads(const std::uint8_t* quads, std::size_t stride, const PanelInputs& panel, std::size_t first_pose,
               std::int32_t (&sums)[poses][rows]) {
  constexpr int vectors = rows / 4;
  const v128_t even = wasm_i16x8_const_splat(255);
  v128_t sum[poses][vectors];
  for (int p = 0; p < poses; ++p)
    for (v128_t& s : sum[p]) s = wasm_i32x4_splat(static_cast<std::int32_t>(panel.initial_sums[first_pose + p]));
  const std::int16_t* inputs = panel.values + 4 * first_pose;
  for (std::size_t k = 0; k < panel.count; k += 4, inputs += 4 * panel.poses, quads += stride)
    for (int v = 0; v < vectors; ++v) {
      const v128_t weights = wasm_v128_load(quads + 16 * v);
      const v128_t first = wasm_v128_and(weights, even), last = wasm_u16x8_shr(weights, 8);
      for (int p = 0; p < poses; ++p) {
        const v128_t x = wasm_v128_load32_splat(inputs + 4 * p), y = wasm_v128_load32_splat(inputs + 4 * p + 2);
        sum[p][v] = wasm_i32x4_add(sum[p][v], wasm_i32x4_dot_i16x8(first, x));
        sum[p][v] = wasm_i32x4_add(sum[p][v], wasm_i32x4_dot_i16x8(last, y));
      }
    }
  for (int p = 0; p < poses; ++p)
    for (int v = 0; v < vectors; ++v) wasm_v128_store(sums[p] + 4 * v, sum[p][v]);
}

#include "runtime/kernels/strips.h"

}  // namespace

const PoseKernels wasm_simd_kernels = make_kernels("wasm-simd", column_product<32, 16, 2>, quad_product<32, 16, 2>);

}  // namespace fb::runtime
