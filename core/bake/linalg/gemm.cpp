#include "bake/linalg/gemm.h"

namespace fb {
namespace gemm_base {
void gemm(Op, Op, std::size_t, std::size_t, std::size_t, const float*, std::size_t, const float*, std::size_t, float,
          float*, std::size_t);
}
#ifdef FB_GEMM_X86
namespace gemm_avx2 {
decltype(gemm_base::gemm) gemm;
}
namespace gemm_avx512 {
decltype(gemm_base::gemm) gemm;
}
#endif

static decltype(&gemm_base::gemm) choose() {
#ifdef FB_GEMM_X86
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) return gemm_avx512::gemm;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return gemm_avx2::gemm;
#endif
  return gemm_base::gemm;
}

void gemm(Op a_op, Op b_op, std::size_t rows, std::size_t columns, std::size_t inner, const float* a, std::size_t lda,
          const float* b, std::size_t ldb, float keep, float* c, std::size_t ldc) {
  static const auto chosen = choose();
  chosen(a_op, b_op, rows, columns, inner, a, lda, b, ldb, keep, c, ldc);
}

}  // namespace fb
