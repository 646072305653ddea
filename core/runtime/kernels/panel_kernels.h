// The hot loops of the runtime, once for each instruction set. All of them give the same bits; this header is all that
// their files include, because what else they compiled inline might be linked into code for lesser processors.
#pragma once

#include <cstddef>
#include <cstdint>

#include "model/activation.h"

namespace fb {

// How many poses go through the runtime together where there are many: digits are read and unpacked once for all.
inline constexpr std::size_t block_poses = 8;

// Rows of a panel at most.
inline constexpr std::size_t panel_rows = 64;

// The columns of a panel that are multiplied with something.
struct ActiveColumns {
  const std::uint32_t* places;  // which column each is
  // What it is multiplied with, -32512..32512: four columns after four, and of each four pose after pose. Not null.
  const std::int16_t* inputs;
  std::size_t count;           // a multiple of 4: filled up with inputs of 0 at places there are
  std::size_t poses;           // 1 or block_poses
  const std::uint32_t* start;  // of each pose: -128 x the sum of its inputs, modulo 2^32
  // Where the digits begin that are needed next, probably of the same columns; asked for meanwhile. May be null, and
  // columns may be beyond what is there.
  const std::uint8_t* ahead = nullptr;
};

// sums[panel_rows * p + r] = sum over the active columns of pose p's input x digit r of the column, for r < rows: 16,
// 32, 48 or 64. Columns lie one after the other in `digits`, `rows` bytes each, each holding a digit + 128, of which
// `start` is the undoing. The caller sees to it that no sum leaves 32 bits; on the way sums may, modulo 2^32.
using PanelSums = void (*)(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active,
                           std::int32_t* sums);

// Lists of floats have room up to the next multiple of this.
inline constexpr std::size_t padding = 16;

// What became of numbers that were rounded to multiples of one step, and their sum and how many are 0 in steps.
struct Rounded {
  float step = 0;  // 0: all numbers are, and none is written
  std::uint32_t sum = 0, zeros = 0;
};

struct PoseKernels {
  const char* name;
  PanelSums panel_sums;
  // The loops of vector_passes.h.
  Rounded (*round_all)(float* x, std::size_t count, float limit, std::int16_t* wholes);
  // The same for each pose of a block, whose numbers lie side by side; wholes lie as ActiveColumns::inputs do, zeros
  // are not counted, and those of poses that are all zeros are written.
  void (*round_block)(float* x, std::size_t count, float limit, std::int16_t* wholes, Rounded* rounded);
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

}  // namespace fb
