#define FB_KERNELS kernels_avx512
#define Eigen Eigen_avx512
#include "bake/linalg/gemm_kernel.inl"
#include "bake/linalg/layer_kernels.inl"
