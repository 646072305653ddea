// The hot loops of the runtime, once for each instruction set. All of them give the same bits; this header is all that
// their files include, because what else they compiled inline might be linked into code for lesser processors.
#pragma once

#include <cstddef>
#include <cstdint>

namespace fb {

// The columns of a panel that are multiplied with something.
struct ActiveColumns {
  const std::uint32_t* places;  // which column each is
  const std::int16_t* inputs;   // what it is multiplied with, -32512..32512
  std::size_t count;            // a multiple of 4: filled up with inputs of 0 at places there are
  std::uint32_t start;          // -128 x the sum of inputs, modulo 2^32
};

// sums[r] = sum over the active columns of input x digit r of the column, for r < rows: 16, 32, 48 or 64. Columns lie
// one after the other in `digits`, `rows` bytes each, each holding a digit + 128, of which `start` is the undoing. The
// caller sees to it that no sum leaves 32 bits; on the way sums may, modulo 2^32.
using PanelSums = void (*)(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active,
                           std::int32_t* sums);

struct Kernels {
  const char* name;
  PanelSums panel_sums;
};

extern const Kernels scalar_kernels;
#if defined(__x86_64__)
extern const Kernels sse2_kernels, avx2_kernels, avx_vnni_kernels, avx512_vnni_kernels;
#elif defined(__aarch64__)
extern const Kernels neon_kernels, neon_dot_kernels;
#elif defined(__wasm_simd128__)
extern const Kernels wasm_simd_kernels;
#endif

}  // namespace fb
