#include "bake/linalg/kernels.h"

namespace fb::bake {
namespace kernels_base {
extern const Kernels kernels;
}
#ifdef FB_KERNELS_X86
namespace kernels_avx2 {
extern const Kernels kernels;
}
namespace kernels_avx512 {
extern const Kernels kernels;
decltype(bake::gemm) gemm_bf16;
}  // namespace kernels_avx512

#endif

const std::vector<Kernels>& supported_kernels() {
  static const std::vector<Kernels> supported = [] {
    std::vector<Kernels> widest_first;
#ifdef FB_KERNELS_X86
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) {
      widest_first.push_back(kernels_avx512::kernels);
      if (__builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512bf16"))
        widest_first.back().gemm_bf16 = kernels_avx512::gemm_bf16;
    }
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) widest_first.push_back(kernels_avx2::kernels);
#endif
    widest_first.push_back(kernels_base::kernels);
    return widest_first;
  }();
  return supported;
}

const Kernels& kernels() {
  return supported_kernels().front();
}

void gemm(Op a_op, Op b_op, std::size_t rows, std::size_t columns, std::size_t inner, const float* a, std::size_t lda,
          const float* b, std::size_t ldb, float beta, float* c, std::size_t ldc) {
  kernels().gemm(a_op, b_op, rows, columns, inner, a, lda, b, ldb, beta, c, ldc);
}

}  // namespace fb::bake
