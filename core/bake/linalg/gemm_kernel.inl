// The body of gemm, compiled once per instruction set. Eigen gets a namespace of its own in each, so that the linker
// never replaces templates of one instruction set by those of another. The including file names the namespace in
// FB_KERNELS.
#define EIGEN_DONT_PARALLELIZE
#define EIGEN_MPL2_ONLY
#include <Eigen/Core>

#include "bake/linalg/gemm.h"

namespace fb::bake::FB_KERNELS {

void gemm(Op a_op, Op b_op, std::size_t rows, std::size_t columns, std::size_t inner, const float* a, std::size_t lda,
          const float* b, std::size_t ldb, float beta, float* c, std::size_t ldc) {
  using Stored = Eigen::Map<const Eigen::MatrixXf, 0, Eigen::OuterStride<>>;
  Eigen::Map<Eigen::MatrixXf, 0, Eigen::OuterStride<>> C(c, rows, columns, Eigen::OuterStride<>(ldc));
  const bool ta = a_op == Op::transposed, tb = b_op == Op::transposed;
  const Stored A(a, ta ? inner : rows, ta ? rows : inner, Eigen::OuterStride<>(lda));
  const Stored B(b, tb ? columns : inner, tb ? inner : columns, Eigen::OuterStride<>(ldb));
  if (beta == 0) C.setZero();
  if (!ta && !tb) C.noalias() += A * B;
  if (ta && !tb) C.noalias() += A.transpose() * B;
  if (!ta && tb) C.noalias() += A * B.transpose();
  if (ta && tb) C.noalias() += A.transpose() * B.transpose();
}

}  // namespace fb::bake::FB_KERNELS
