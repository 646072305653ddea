#define FB_KERNELS kernels_avx2
#define Eigen Eigen_avx2
#include "bake/linalg/gemm_kernel.inl"
#include "bake/linalg/layer_kernels.inl"
