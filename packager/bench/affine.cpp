#define FB_AFFINE affine_base
#define FB_AFFINE_NAME "baseline"
#include "bench/affine_kernel.inl"

namespace fb::tool {

#if defined(__x86_64__)
extern const AffineKernels affine_avx2, affine_avx512;
#endif

const AffineKernels& affine_kernels() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("fma")) return affine_avx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return affine_avx2;
#endif
  return affine_base;
}

}  // namespace fb::tool
