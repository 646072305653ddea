// Products of matrices rounded to bf16, for processors with AVX512-BF16. The instruction multiplies pairs: lane r of a
// sum gets a(r, k) b(k) + a(r, k + 1) b(k + 1). So a is packed as 32-bit lanes of two bf16, rows side by side, and two
// consecutive b are broadcast together.
#include <immintrin.h>

#include <new>

#include "bake/linalg/kernels.h"

namespace fb::bake::kernels_avx512 {
namespace {

constexpr std::size_t vector_bytes = 64, lanes = 16;  // of 32 bits
constexpr std::size_t panel_vectors = 4;              // of rows that are summed together
constexpr std::size_t tile_columns = 6;

using Pair = std::uint32_t;  // two bf16: the first in the lower half

// Packed factors of a thread's products. Like layer_kernels.inl, this file must not use inline library functions.
struct Buffer {
  Pair* data = nullptr;
  std::size_t size = 0;
  ~Buffer() { operator delete (data, std::align_val_t{vector_bytes}); }
  Pair* of_size(std::size_t pairs) {
    if (pairs > size) {
      operator delete (data, std::align_val_t{vector_bytes});
      data = nullptr, size = 0;
      data = static_cast<Pair*>(operator new (pairs * sizeof(Pair), std::align_val_t{vector_bytes}));
      size = pairs;
    }
    return data;
  }
};

__mmask16 first_lanes(std::size_t count) {
  return count >= lanes ? 0xffff : static_cast<__mmask16>((1u << count) - 1);
}

// Two vectors of floats as pairs: lane i has low[i] and high[i].
__m512i interleave(__m512 low, __m512 high) {
  const __m512i order = _mm512_set_epi16(31, 15, 30, 14, 29, 13, 28, 12, 27, 11, 26, 10, 25, 9, 24, 8, 23, 7, 22, 6, 21,
                                         5, 20, 4, 19, 3, 18, 2, 17, 1, 16, 0);
  return _mm512_permutexvar_epi16(order, reinterpret_cast<__m512i>(_mm512_cvtne2ps_pbh(high, low)));
}

// 32 consecutive floats as 16 pairs of neighbours; those from `count` on are 0.
__m512i neighbours(const float* from, std::size_t count) {
  const __m512 low = _mm512_maskz_loadu_ps(first_lanes(count), from);
  const __m512 high = _mm512_maskz_loadu_ps(count > lanes ? first_lanes(count - lanes) : __mmask16{0}, from + lanes);
  return reinterpret_cast<__m512i>(_mm512_cvtne2ps_pbh(high, low));
}

// Pairs of two consecutive columns of a matrix of `stride` floats a column: to[pair of columns][row], `padded` rows a
// pair, a multiple of 16.
void pack_columns(const float* from, std::size_t stride, std::size_t rows, std::size_t columns, std::size_t padded,
                  Pair* to) {
  for (std::size_t k = 0; k < columns; k += 2, to += padded) {
    const float* const low = from + k * stride;
    for (std::size_t r = 0; r < padded; r += lanes) {
      const __mmask16 mask = r < rows ? first_lanes(rows - r) : __mmask16{0};
      const __m512 first = _mm512_maskz_loadu_ps(mask, low + r);
      const __m512 second = k + 1 < columns ? _mm512_maskz_loadu_ps(mask, low + stride + r) : _mm512_setzero_ps();
      _mm512_store_si512(to + r, interleave(first, second));
    }
  }
}

// Pairs of two consecutive rows of each column: to[column][pair of rows], `padded` pairs a column, a multiple of 16.
void pack_rows(const float* from, std::size_t stride, std::size_t rows, std::size_t columns, std::size_t padded,
               Pair* to) {
  for (std::size_t c = 0; c < columns; ++c, from += stride)
    for (std::size_t pair = 0; pair < padded; pair += lanes, to += lanes)
      _mm512_store_si512(to, 2 * pair < rows ? neighbours(from + 2 * pair, rows - 2 * pair) : _mm512_setzero_si512());
}

// Transposes 16 x 16 lanes.
void transpose(__m512i rows[lanes]) {
  __m512i t[lanes];
  for (std::size_t i = 0; i < lanes; i += 2) {
    t[i] = _mm512_unpacklo_epi32(rows[i], rows[i + 1]);
    t[i + 1] = _mm512_unpackhi_epi32(rows[i], rows[i + 1]);
  }
  for (std::size_t i = 0; i < lanes; i += 4) {
    rows[i] = _mm512_unpacklo_epi64(t[i], t[i + 2]);
    rows[i + 1] = _mm512_unpackhi_epi64(t[i], t[i + 2]);
    rows[i + 2] = _mm512_unpacklo_epi64(t[i + 1], t[i + 3]);
    rows[i + 3] = _mm512_unpackhi_epi64(t[i + 1], t[i + 3]);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    t[i] = _mm512_shuffle_i32x4(rows[i], rows[i + 4], 0x88);
    t[i + 4] = _mm512_shuffle_i32x4(rows[i], rows[i + 4], 0xdd);
    t[i + 8] = _mm512_shuffle_i32x4(rows[i + 8], rows[i + 12], 0x88);
    t[i + 12] = _mm512_shuffle_i32x4(rows[i + 8], rows[i + 12], 0xdd);
  }
  for (std::size_t i = 0; i < 8; ++i) {
    rows[i] = _mm512_shuffle_i32x4(t[i], t[i + 8], 0x88);
    rows[i + 8] = _mm512_shuffle_i32x4(t[i], t[i + 8], 0xdd);
  }
}

// Pairs of two consecutive rows of a matrix, columns side by side: to[pair of rows][column], `padded` columns a pair, a
// multiple of 16.
void pack_transposed(const float* from, std::size_t stride, std::size_t rows, std::size_t columns, std::size_t padded,
                     Pair* to) {
  for (std::size_t c = 0; c < padded; c += lanes)
    for (std::size_t r = 0; r < rows; r += 2 * lanes) {
      __m512i tile[lanes];
      for (std::size_t i = 0; i < lanes; ++i)
        tile[i] = c + i < columns ? neighbours(from + (c + i) * stride + r, rows - r) : _mm512_setzero_si512();
      transpose(tile);
      for (std::size_t i = 0; i < lanes && r + 2 * i < rows; ++i)
        _mm512_store_si512(to + (r / 2 + i) * padded + c, tile[i]);
    }
}

// A packed right factor: the pair of column c and inner indices 2 k and 2 k + 1 is data[k * inner_step + c *
// column_step].
struct RightFactor {
  const Pair* data;
  std::size_t inner_step, column_step;
};

// Sums of `vectors` x 16 rows and `columns` columns. a: of `stride` pairs an inner pair.
template <std::size_t vectors, std::size_t columns>
void multiply_tile(std::size_t inner_pairs, const Pair* a, std::size_t stride, const RightFactor& b, float beta,
                   float* c, std::size_t ldc, __mmask16 last) {
  __m512 sum[columns][vectors];
#pragma GCC unroll 8
  for (std::size_t j = 0; j < columns; ++j)
#pragma GCC unroll 8
    for (std::size_t v = 0; v < vectors; ++v) sum[j][v] = _mm512_setzero_ps();
  const Pair* right = b.data;
  for (std::size_t k = 0; k < inner_pairs; ++k, a += stride, right += b.inner_step) {
    __m512bh left[vectors];
#pragma GCC unroll 8
    for (std::size_t v = 0; v < vectors; ++v) left[v] = reinterpret_cast<__m512bh>(_mm512_load_si512(a + v * lanes));
#pragma GCC unroll 8
    for (std::size_t j = 0; j < columns; ++j) {
      const __m512bh factor = reinterpret_cast<__m512bh>(_mm512_set1_epi32(static_cast<int>(right[j * b.column_step])));
#pragma GCC unroll 8
      for (std::size_t v = 0; v < vectors; ++v) sum[j][v] = _mm512_dpbf16_ps(sum[j][v], left[v], factor);
    }
  }
#pragma GCC unroll 8
  for (std::size_t j = 0; j < columns; ++j)
#pragma GCC unroll 8
    for (std::size_t v = 0; v < vectors; ++v) {
      float* const to = c + j * ldc + v * lanes;
      const __mmask16 mask = v + 1 < vectors ? __mmask16{0xffff} : last;
      if (beta != 0) sum[j][v] = _mm512_add_ps(sum[j][v], _mm512_maskz_loadu_ps(mask, to));
      _mm512_mask_storeu_ps(to, mask, sum[j][v]);
    }
}

// multiply_tile for each number of vectors and of columns, from 1.
using MultiplyTile = decltype(&multiply_tile<1, 1>);
template <std::size_t vectors>
constexpr MultiplyTile tiles_of_vectors[tile_columns] = {multiply_tile<vectors, 1>, multiply_tile<vectors, 2>,
                                                         multiply_tile<vectors, 3>, multiply_tile<vectors, 4>,
                                                         multiply_tile<vectors, 5>, multiply_tile<vectors, 6>};
constexpr const MultiplyTile* tiles[panel_vectors] = {tiles_of_vectors<1>, tiles_of_vectors<2>, tiles_of_vectors<3>,
                                                      tiles_of_vectors<4>};

std::size_t at_most(std::size_t count, std::size_t most) {
  return count < most ? count : most;
}

}  // namespace

void gemm_bf16(Op a_op, Op b_op, std::size_t rows, std::size_t columns, std::size_t inner, const float* a,
               std::size_t lda, const float* b, std::size_t ldb, float beta, float* c, std::size_t ldc) {
  static thread_local Buffer left_buffer, right_buffer;
  const std::size_t padded = (rows + lanes - 1) / lanes * lanes, pairs = (inner + 1) / 2;
  Pair* const left = left_buffer.of_size(padded * pairs);
  if (a_op == Op::plain)
    pack_columns(a, lda, rows, inner, padded, left);
  else
    pack_transposed(a, lda, inner, rows, padded, left);

  RightFactor right;
  if (b_op == Op::plain) {
    const std::size_t padded_pairs = (pairs + lanes - 1) / lanes * lanes;
    Pair* const packed = right_buffer.of_size(padded_pairs * columns);
    pack_rows(b, ldb, inner, columns, padded_pairs, packed);
    right = {packed, 1, padded_pairs};
  } else {
    const std::size_t padded_columns = (columns + lanes - 1) / lanes * lanes;
    Pair* const packed = right_buffer.of_size(padded_columns * pairs);
    pack_columns(b, ldb, columns, inner, padded_columns, packed);
    right = {packed, padded_columns, 1};
  }

  for (std::size_t r = 0; r < rows; r += panel_vectors * lanes) {
    const std::size_t vectors = at_most((rows - r + lanes - 1) / lanes, panel_vectors);
    const __mmask16 last = first_lanes(rows - r - (vectors - 1) * lanes);
    for (std::size_t j = 0; j < columns; j += tile_columns)
      tiles[vectors - 1][at_most(columns - j, tile_columns) - 1](
          pairs, left + r, padded, {right.data + j * right.column_step, right.inner_step, right.column_step}, beta,
          c + r + j * ldc, ldc, last);
  }
}

}  // namespace fb::bake::kernels_avx512
