#define FB_AFFINE affine_avx2
#define FB_AFFINE_NAME "avx2, fma"
#define Eigen Eigen_affine_avx2
#include "bench/affine_kernel.inl"
