#define FB_GEMM gemm_base
#define Eigen Eigen_base
#include "bake/linalg/gemm_kernel.inl"
