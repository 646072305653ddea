#define FB_AFFINE affine_avx512
#define FB_AFFINE_NAME "avx512"
#define Eigen Eigen_affine_avx512
#include "bench/affine_kernel.inl"
