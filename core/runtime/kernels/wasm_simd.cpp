#include <wasm_simd128.h>

#include "runtime/kernels/panel_kernels.h"

namespace fb {
namespace {

#include "runtime/kernels/vector_passes.h"

// 16 rows at a time: two columns become pairs of 16-bit numbers, which one instruction multiplies and adds.
void panel_sums(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::int32_t* sums) {
  for (std::size_t r = 0; r < rows; r += 16) {
    v128_t sum[4];
    for (v128_t& s : sum) s = wasm_i32x4_splat(static_cast<std::int32_t>(active.start));
    for (std::size_t k = 0; k < active.count; k += 2) {
      const v128_t a = wasm_v128_load(digits + active.places[k] * rows + r);
      const v128_t b = wasm_v128_load(digits + active.places[k + 1] * rows + r);
      const v128_t input = wasm_v128_load32_splat(active.inputs + k);
      const v128_t first = wasm_i8x16_shuffle(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
      const v128_t last = wasm_i8x16_shuffle(a, b, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
      sum[0] = wasm_i32x4_add(sum[0], wasm_i32x4_dot_i16x8(wasm_u16x8_extend_low_u8x16(first), input));
      sum[1] = wasm_i32x4_add(sum[1], wasm_i32x4_dot_i16x8(wasm_u16x8_extend_high_u8x16(first), input));
      sum[2] = wasm_i32x4_add(sum[2], wasm_i32x4_dot_i16x8(wasm_u16x8_extend_low_u8x16(last), input));
      sum[3] = wasm_i32x4_add(sum[3], wasm_i32x4_dot_i16x8(wasm_u16x8_extend_high_u8x16(last), input));
    }
    for (int i = 0; i < 4; ++i) wasm_v128_store(sums + r + 4 * i, sum[i]);
  }
}

}  // namespace

const PoseKernels wasm_simd_kernels = {"wasm-simd",  panel_sums, round_all, move_rows,
                                       finish_layer, to_halves,  normalise};

}  // namespace fb
