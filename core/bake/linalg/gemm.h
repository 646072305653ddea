#pragma once

#include <cstddef>

namespace fb::bake {

enum class Op { plain, transposed };

// C = op(A) op(B) + beta * C for column-major float matrices: op(A) is rows x inner, op(B) inner x columns, C rows x
// columns; lda, ldb and ldc are the leading dimensions as stored. beta is 0 (C may be uninitialised) or 1. Runs on the
// calling thread, with Eigen compiled for the widest vectors of this processor: same bits on the same kind of
// processor.
void gemm(Op a_op, Op b_op, std::size_t rows, std::size_t columns, std::size_t inner, const float* a, std::size_t lda,
          const float* b, std::size_t ldb, float beta, float* c, std::size_t ldc);

}  // namespace fb::bake
