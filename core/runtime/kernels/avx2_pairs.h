// Sums over pairs of columns with 256-bit vectors: included by the AVX2 kernel files inside an unnamed namespace, after
// multiply_add(sum, weights, input), which adds the products of pairs of 16-bit numbers, is defined.

// Interleaves 16 rows of two columns, two rows at a time. 32 rows have two pieces: the low and the high quarters of
// both 128-bit lanes. With `last`: the 16 rows after `piece` pieces.
template <bool last>
__m256i interleave(const std::uint8_t* a, const std::uint8_t* b, int piece) {
  if constexpr (last) {
    const __m128i x = _mm_loadu_si128(reinterpret_cast<const __m128i*>(a + 16 * piece));
    const __m128i y = _mm_loadu_si128(reinterpret_cast<const __m128i*>(b + 16 * piece));
    return _mm256_set_m128i(_mm_unpackhi_epi16(x, y), _mm_unpacklo_epi16(x, y));
  } else {
    const __m256i x = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(a + 32 * (piece / 2)));
    const __m256i y = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(b + 32 * (piece / 2)));
    return piece % 2 == 0 ? _mm256_unpacklo_epi16(x, y) : _mm256_unpackhi_epi16(x, y);
  }
}

// Sums of `pieces` pieces, starting at piece `first`, and with `last` of the 16 rows after them. In two interleaved
// columns, even bytes are the even rows of both and odd bytes the odd rows, so accumulators are permuted when they are
// stored. Sixteen registers hold at most eight accumulators.
template <int first, int pieces, bool last, int poses>
void sum_columns(const std::uint8_t* digits, const PanelInputs& panel, std::size_t first_pose, std::int32_t* sums) {
  const __m256i even = _mm256_set1_epi16(255);
  __m256i sum[poses][pieces + last][2];
  for (int p = 0; p < poses; ++p)
    for (auto& piece : sum[p])
      for (__m256i& s : piece) s = _mm256_set1_epi32(static_cast<int>(panel.initial_sums[first_pose + p]));
  const std::uint32_t* index = panel.indices;
  const std::int16_t* inputs = panel.values + 4 * first_pose;
  for (std::size_t k = 0; k < panel.count; k += 4, index += 4, inputs += 4 * panel.poses) {
    const std::size_t at[4] = {index[0] * column_panel_rows, index[1] * column_panel_rows, index[2] * column_panel_rows,
                               index[3] * column_panel_rows};
    for (int pair = 0; pair < 4; pair += 2) {
      const std::uint8_t *a = digits + at[pair], *b = digits + at[pair + 1];
      const auto add = [&](int i, __m256i both) {
        const __m256i even_rows = _mm256_and_si256(both, even), odd_rows = _mm256_srli_epi16(both, 8);
        for (int p = 0; p < poses; ++p) {
          int numbers;
          __builtin_memcpy(&numbers, inputs + 4 * p + pair, sizeof numbers);
          const __m256i input = _mm256_set1_epi32(numbers);
          sum[p][i][0] = multiply_add(sum[p][i][0], even_rows, input);
          sum[p][i][1] = multiply_add(sum[p][i][1], odd_rows, input);
        }
      };
      for (int i = 0; i < pieces; ++i) add(i, interleave<false>(a, b, first + i));
      if constexpr (last) add(pieces, interleave<true>(a, b, pieces));
    }
  }
  for (int p = 0; p < poses; ++p)
    for (int i = 0; i < pieces + last; ++i) {
      const int piece = first + i;
      const __m256i low = _mm256_unpacklo_epi32(sum[p][i][0], sum[p][i][1]);
      const __m256i high = _mm256_unpackhi_epi32(sum[p][i][0], sum[p][i][1]);
      const int row = i == pieces ? 16 * pieces : 32 * (piece / 2) + 8 * (piece % 2);
      auto* to = reinterpret_cast<__m256i*>(sums + max_panel_rows * (first_pose + p) + row);
      _mm256_storeu_si256(to, _mm256_permute2x128_si256(low, high, 0x20));
      _mm256_storeu_si256(to + (i == pieces ? 1 : 2), _mm256_permute2x128_si256(low, high, 0x31));
    }
}

// Sums of 8 * vectors rows: a vector holds eight rows of a quad.
template <int vectors, int poses>
void sum_quads(const std::uint8_t* quads, std::size_t rows, const PanelInputs& panel, std::size_t first_pose,
               std::int32_t* sums) {
  const __m256i even = _mm256_set1_epi16(255);
  __m256i sum[poses][vectors];
  for (int p = 0; p < poses; ++p)
    for (__m256i& s : sum[p]) s = _mm256_set1_epi32(static_cast<int>(panel.initial_sums[first_pose + p]));
  const std::int16_t* inputs = panel.values + 4 * first_pose;
  for (std::size_t k = 0; k < panel.count; k += 4, inputs += 4 * panel.poses, quads += 4 * rows) {
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
    for (int v = 0; v < vectors; ++v)
      _mm256_storeu_si256(reinterpret_cast<__m256i*>(sums + max_panel_rows * (first_pose + p)) + v, sum[p][v]);
}

// Sums of a block of poses, four poses and one piece at a time.
void block_sums(const std::uint8_t* digits, std::size_t rows, const PanelInputs& panel, std::int32_t* sums) {
  for (std::size_t r = 0; r < rows; r += 32)
    for (std::size_t pose = 0; pose < poses_per_block; pose += 4)
      if (r + 32 <= rows) {
        sum_columns<0, 1, false, 4>(digits + r, panel, pose, sums + r);
        sum_columns<1, 1, false, 4>(digits + r, panel, pose, sums + r);
      } else {
        sum_columns<0, 0, true, 4>(digits + r, panel, pose, sums + r);
      }
}

void column_sums(const std::uint8_t* digits, std::size_t rows, const PanelInputs& panel, std::int32_t* sums) {
  if (panel.poses == poses_per_block) return block_sums(digits, rows, panel, sums);
  std::size_t r = 0;
  for (; r + 64 <= rows; r += 64) sum_columns<0, 4, false, 1>(digits + r, panel, 0, sums + r);
  switch (rows - r) {
    case 48:
      return sum_columns<0, 2, true, 1>(digits + r, panel, 0, sums + r);
    case 32:
      return sum_columns<0, 2, false, 1>(digits + r, panel, 0, sums + r);
    case 16:
      return sum_columns<0, 0, true, 1>(digits + r, panel, 0, sums + r);
  }
}

void quad_sums(const std::uint8_t* quads, std::size_t rows, const PanelInputs& panel, std::int32_t* sums) {
  if (panel.poses == poses_per_block) {
    for (std::size_t r = 0; r < rows; r += 16)
      for (std::size_t pose = 0; pose < poses_per_block; pose += 4)
        sum_quads<2, 4>(quads + 4 * r, rows, panel, pose, sums + r);
    return;
  }
  std::size_t r = 0;
  for (; r + 64 <= rows; r += 64) sum_quads<8, 1>(quads + 4 * r, rows, panel, 0, sums + r);
  switch (rows - r) {
    case 48:
      return sum_quads<6, 1>(quads + 4 * r, rows, panel, 0, sums + r);
    case 32:
      return sum_quads<4, 1>(quads + 4 * r, rows, panel, 0, sums + r);
    case 16:
      return sum_quads<2, 1>(quads + 4 * r, rows, panel, 0, sums + r);
  }
}
