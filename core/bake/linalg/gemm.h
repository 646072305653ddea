#pragma once

#include <cstddef>

namespace fb::bake {

enum class Op { plain, transposed };

// C = op(A) op(B) + keep * C for column-major float matrices: op(A) is rows x inner, op(B) inner x columns, C rows x
// columns; lda, ldb, ldc are the distances between columns as stored. keep is 0 (C may hold anything) or 1.
// Runs on the calling thread, with Eigen compiled for the widest vectors the processor has: same bits on the same kind
// of processor, whatever runs beside it.
void gemm(Op a_op, Op b_op, std::size_t rows, std::size_t columns, std::size_t inner, const float* a, std::size_t lda,
          const float* b, std::size_t ldb, float keep, float* c, std::size_t ldc);

}  // namespace fb::bake
