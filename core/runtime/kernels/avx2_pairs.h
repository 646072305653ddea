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

// Sums of 16 * pieces rows, starting at piece `first` of a group of 32 rows. Even rows are summed with 256 times the
// odd ones behind them.
template <int first, int pieces, int poses>
void sum_columns(const std::uint8_t* digits, const PanelInputs& panel, std::size_t first_pose,
                 std::int32_t (*sums)[64]) {
  __m256i sum[poses][pieces][2];
  for (int p = 0; p < poses; ++p)
    for (auto& [both, odd] : sum[p]) {
      both = _mm256_set1_epi32(static_cast<int>(panel.initial_sums[first_pose + p]));
      odd = _mm256_setzero_si256();
    }
  const std::uint32_t* at = panel.offsets;
  const std::int16_t* inputs = panel.values + 4 * first_pose;
  for (std::size_t k = 0; k < panel.count; k += 4, at += 4, inputs += 4 * panel.poses) {
    for (int pair = 0; pair < 4; pair += 2) {
      const std::uint8_t *a = digits + at[pair], *b = digits + at[pair + 1];
      for (int i = 0; i < pieces; ++i) {
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
  }
  for (int p = 0; p < poses; ++p)
    for (int i = 0; i < pieces; ++i) {
      const auto& [both, odd] = sum[p][i];
      auto* const to = reinterpret_cast<__m256i*>(sums[p]) + 2 * i;
      _mm256_storeu_si256(to, _mm256_sub_epi32(both, _mm256_slli_epi32(odd, 8)));
      _mm256_storeu_si256(to + 1, odd);
    }
}

// Sums of 8 * vectors rows: a vector holds eight rows of a quad.
template <int vectors, int poses>
void sum_quads(const std::uint8_t* quads, std::size_t stride, const PanelInputs& panel, std::size_t first_pose,
               std::int32_t (*sums)[64]) {
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

// Sixteen registers hold at most eight accumulators: 64 rows of a pose, or 16 rows of four poses.
void column_product(const Panel& panel, const PanelInputs& inputs, const PanelOutput& output) {
  std::int32_t sums[4][64];
  for (std::size_t r = 0; r < panel.rows; r += 64) {
    const std::uint8_t* const digits = panel.digits + r;
    if (inputs.poses == 1) {
      if (r + 32 < panel.rows) {
        sum_columns<0, 4, 1>(digits, inputs, 0, sums);
        finish_rows(panel, output, 0, r, 64, sums[0]);
      } else {
        sum_columns<0, 2, 1>(digits, inputs, 0, sums);
        finish_rows(panel, output, 0, r, 32, sums[0]);
      }
      continue;
    }
    for (std::size_t group = 0; group < 64 && r + group < panel.rows; group += 32)
      for (std::size_t pose = 0; pose < poses_per_block; pose += 4) {
        sum_columns<0, 1, 4>(digits + group, inputs, pose, sums);
        for (std::size_t p = 0; p < 4; ++p) finish_rows(panel, output, pose + p, r + group, 16, sums[p]);
        sum_columns<1, 1, 4>(digits + group, inputs, pose, sums);
        for (std::size_t p = 0; p < 4; ++p) finish_rows(panel, output, pose + p, r + group + 16, 16, sums[p]);
      }
  }
}

void quad_product(const Panel& panel, const PanelInputs& inputs, const PanelOutput& output) {
  std::int32_t sums[4][64];
  if (inputs.poses == poses_per_block) {
    for (std::size_t r = 0; r < panel.rows; r += 16)
      for (std::size_t pose = 0; pose < poses_per_block; pose += 4) {
        sum_quads<2, 4>(panel.digits + 4 * r, panel.stride, inputs, pose, sums);
        for (std::size_t p = 0; p < 4; ++p) finish_rows(panel, output, pose + p, r, 16, sums[p]);
      }
    return;
  }
  for (std::size_t r = 0; r < panel.rows; r += 64) {
    const std::uint8_t* const quads = panel.digits + 4 * r;
    if (r + 48 < panel.rows)
      sum_quads<8, 1>(quads, panel.stride, inputs, 0, sums);
    else if (r + 32 < panel.rows)
      sum_quads<6, 1>(quads, panel.stride, inputs, 0, sums);
    else if (r + 16 < panel.rows)
      sum_quads<4, 1>(quads, panel.stride, inputs, 0, sums);
    else
      sum_quads<2, 1>(quads, panel.stride, inputs, 0, sums);
    finish_rows(panel, output, 0, r, (panel.rows - r < 64 ? panel.rows - r + 15 : 64) / 16 * 16, sums[0]);
  }
}
