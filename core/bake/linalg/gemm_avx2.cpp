#define FB_GEMM gemm_avx2
#define Eigen Eigen_avx2
#include "bake/linalg/gemm_kernel.inl"
