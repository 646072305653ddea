#define FB_GEMM gemm_avx512
#define Eigen Eigen_avx512
#include "bake/linalg/gemm_kernel.inl"
