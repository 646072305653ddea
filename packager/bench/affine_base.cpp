#define FB_AFFINE affine_base
#define FB_AFFINE_NAME "baseline"
#include "bench/affine_kernel.inl"
