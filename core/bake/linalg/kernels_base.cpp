#define FB_KERNELS kernels_base
#define Eigen Eigen_base
#include "bake/linalg/gemm_kernel.inl"
#include "bake/linalg/layer_kernels.inl"
