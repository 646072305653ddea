// Sums over pairs of columns with 256-bit vectors: included by the AVX2 kernel files inside an unnamed namespace, after
// multiply_add(sum, weights, input), which adds the products of pairs of 16-bit numbers, is defined.

// Where rows of a column are stored. Interleaving two columns two rows at a time leaves four groups of eight rows: the
// even and the odd rows of the low and of the high quarters of the 128-bit lanes. So that a group has consecutive rows,
// these are stored apart.
struct RowsByPiece {
  constexpr RowsByPiece() {
    for (unsigned row = 0; row < column_group; ++row)
      position[row] =
          static_cast<std::uint8_t>(row / 32 * 32 + row % 8 / 4 * 16 + row / 16 % 2 * 8 + row % 4 * 2 + row / 8 % 2);
  }
  std::uint8_t position[column_group] = {};
};
constexpr RowsByPiece rows_by_piece;

// Even rows are summed with 256 times the odd ones behind them. Sixteen registers hold at most eight accumulators: four
// pieces of 16 rows of a pose, or one piece of four poses.
template <int rows, int poses>
void sum_columns(const std::uint8_t* digits, const PanelInputs& panel, std::size_t first_pose,
                 std::int32_t (&sums)[poses][rows]) {
  constexpr int at_once = 4 / poses;
#pragma GCC unroll 2
  for (int first = 0; first < rows / 16; first += at_once) {
    __m256i sum[poses][at_once][2];
    for (int p = 0; p < poses; ++p)
      for (auto& [both, odd] : sum[p]) {
        both = _mm256_set1_epi32(static_cast<int>(panel.initial_sums[first_pose + p]));
        odd = _mm256_setzero_si256();
      }
    const std::uint32_t* at = panel.offsets;
    const std::int16_t* inputs = panel.values + 4 * first_pose;
    for (std::size_t k = 0; k < panel.count; k += 4, at += 4, inputs += 4 * panel.poses)
      for (int pair = 0; pair < 4; pair += 2) {
        const std::uint8_t *a = digits + at[pair], *b = digits + at[pair + 1];
        for (int i = 0; i < at_once; ++i) {
          const int piece = first + i;
          const __m256i x = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(a + 32 * (piece / 2)));
          const __m256i y = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(b + 32 * (piece / 2)));
          const __m256i both = piece % 2 == 0 ? _mm256_unpacklo_epi16(x, y) : _mm256_unpackhi_epi16(x, y);
          const __m256i odd = _mm256_srai_epi16(both, 8);
          for (int p = 0; p < poses; ++p) {
            int numbers;
            __builtin_memcpy(&numbers, inputs + 4 * p + pair, sizeof numbers);
            const __m256i input = _mm256_set1_epi32(numbers);
            sum[p][i][0] = multiply_add(sum[p][i][0], both, input);
            sum[p][i][1] = multiply_add(sum[p][i][1], odd, input);
          }
        }
      }
    for (int p = 0; p < poses; ++p)
      for (int i = 0; i < at_once; ++i) {
        const auto& [both, odd] = sum[p][i];
        auto* const to = reinterpret_cast<__m256i*>(sums[p]) + 2 * (first + i);
        _mm256_storeu_si256(to, _mm256_sub_epi32(both, _mm256_slli_epi32(odd, 8)));
        _mm256_storeu_si256(to + 1, odd);
      }
  }
}

// A vector holds eight rows of a quad.
template <int rows, int poses>
void sum_quads(const std::uint8_t* quads, std::size_t stride, const PanelInputs& panel, std::size_t first_pose,
               std::int32_t (&sums)[poses][rows]) {
  constexpr int vectors = rows / 8;
  const __m256i even = _mm256_set1_epi16(255);
  __m256i sum[poses][vectors];
  for (int p = 0; p < poses; ++p)
    for (__m256i& s : sum[p]) s = _mm256_set1_epi32(static_cast<int>(panel.initial_sums[first_pose + p]));
  const std::int16_t* inputs = panel.values + 4 * first_pose;
  for (std::size_t k = 0; k < panel.count; k += 4, inputs += 4 * panel.poses, quads += stride) {
    const auto* const weights = reinterpret_cast<const __m256i*>(quads);
    for (int p = 0; p < poses; ++p) {
      int numbers[2];
      __builtin_memcpy(numbers, inputs + 4 * p, sizeof numbers);
      const __m256i x = _mm256_set1_epi32(numbers[0]), y = _mm256_set1_epi32(numbers[1]);
      for (int v = 0; v < vectors; ++v) {
        const __m256i both = _mm256_loadu_si256(weights + v);
        sum[p][v] = multiply_add(sum[p][v], _mm256_and_si256(both, even), x);
        sum[p][v] = multiply_add(sum[p][v], _mm256_srli_epi16(both, 8), y);
      }
    }
  }
  for (int p = 0; p < poses; ++p)
    for (int v = 0; v < vectors; ++v) _mm256_storeu_si256(reinterpret_cast<__m256i*>(sums[p]) + v, sum[p][v]);
}

#include "runtime/kernels/strips.h"
