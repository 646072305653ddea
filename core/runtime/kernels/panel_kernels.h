// The hot loops of the runtime, once for each instruction set. All of them give the same bits; this header is all that
// their files include, because what else they compiled inline might be linked into code for lesser processors.
#pragma once

#include <cstddef>
#include <cstdint>

#include "model/activation.h"
#include "model/control_feature.h"

namespace fb::runtime {

// How many poses go through the runtime together where there are many: digits are read and unpacked once for all.
inline constexpr std::size_t block_poses = 8;

// Rows of a panel at most: of columns, each of which has room for as many if there are fewer, and of quads.
inline constexpr std::size_t column_rows = 192, quad_rows = 128;
inline constexpr std::size_t most_rows = column_rows;

// Columns of a quad, which lie in this order, so that of each row even bytes are the first two and odd bytes the last.
inline constexpr std::size_t quad_columns = 4;
[[gnu::always_inline]] inline std::size_t place_in_quad(std::size_t column) {
  return column % 2 * 2 + column / 2 % 2;
}

// What the columns of a panel are multiplied with, in 1 or block_poses poses.
struct PanelInputs {
  const std::uint32_t* places;  // which column each input is for; not looked at where they are for quads
  // -32512..32512: four after four, and of each four pose after pose. Not null.
  const std::int16_t* inputs;
  std::size_t count;           // a multiple of 4: filled up with inputs of 0, for columns there are
  std::size_t poses;           // 1 or block_poses
  const std::uint32_t* start;  // of each pose: -128 x the sum of its inputs, modulo 2^32
};

// sums[most_rows * p + r] = sum over the columns of pose p's input x digit r of the column, for r < rows, a multiple of
// 16. Each byte of `digits` holds a digit + 128, of which `start` is the undoing. Columns lie one after the other,
// column_rows bytes each; or quads do, 4 x rows bytes each. The caller sees to it that no sum leaves 32 bits; on the
// way sums may, modulo 2^32.
using PanelSums = void (*)(const std::uint8_t* digits, std::size_t rows, const PanelInputs& inputs, std::int32_t* sums);

// Lists of floats have room up to the next multiple of this.
inline constexpr std::size_t padding = 16;

// What became of numbers that were rounded to multiples of one step, and their sum in steps.
struct Rounded {
  float step = 0;  // 0: all numbers are, and none is written
  std::uint32_t sum = 0;
};

// Features of controls, as arrays.
struct ControlFeatures {
  const std::uint32_t* controls;
  const FeatureKind* kinds;
  const float *scales, *thresholds, *falls;
  std::size_t count;
};

struct PoseKernels {
  const char* name;
  PanelSums column_sums, quad_sums;
  // The loops of vector_passes.h.
  bool (*any_nan)(const float* x, std::size_t count);
  // moves[i * step] = control i, within its range, minus what it is at rest. Returns how many were beyond their range.
  std::uint32_t (*clamp_controls)(const float* controls, const float* minimum, const float* maximum, const float* rest,
                                  std::size_t count, float* moves, std::size_t step);
  // The values of all features, of 1 or block_poses poses side by side, as the controls' moves are.
  void (*control_features)(const ControlFeatures& features, const float* moves, std::size_t poses, float* values);
  // Lists the places of values that are not 0 in one pose; there is room for all and 16 more. Returns how many.
  std::size_t (*compact_nonzeros)(const float* values, std::size_t count, std::uint32_t* places);
  Rounded (*quantise_all)(const float* x, std::size_t count, float limit, std::int16_t* quantised);
  // The same for each pose of a block, whose numbers lie side by side; quantised lie as PanelInputs::inputs do, and
  // those of poses that are all zeros are written.
  void (*round_block)(float* x, std::size_t count, float limit, std::int16_t* quantised, Rounded* rounded);
  // rows = rest + step * sums
  void (*move_rows)(const std::int32_t* sums, float step, const float* rest, float* rows, std::size_t count);
  // y = activation((scales * step) * sums + bias), sums = 256 * high + low, or low where high is null
  void (*finish_layer)(const std::int32_t* low, const std::int32_t* high, const float* scales, float step,
                       const float* bias, Activation activation, float* y, std::size_t count);
  void (*to_halves)(const float* numbers, std::uint16_t* halves, std::size_t count);
  void (*normalise)(float* x, float* y, float* z, std::size_t count);
};

extern const PoseKernels scalar_kernels;
#if defined(__x86_64__)
extern const PoseKernels sse2_kernels, avx2_kernels, avx_vnni_kernels, avx512_vnni_kernels;
#elif defined(__aarch64__)
extern const PoseKernels neon_kernels, neon_dot_kernels;
#elif defined(__wasm_simd128__)
extern const PoseKernels wasm_simd_kernels;
#endif

}  // namespace fb::runtime
