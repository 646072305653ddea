// Sums over pairs of columns: included by the files of AVX2's kernels, inside an unnamed namespace and after
// multiply_add(sum, weights, input) is defined, which adds products of pairs of 16-bit numbers.

// Two columns interleaved by two rows at a time: half a block, the first or the second quarter of each of its halves;
// where a block is not whole, all of it.
template <bool whole>
__m256i interleave(const std::uint8_t* a, const std::uint8_t* b, bool second) {
  if constexpr (whole) {
    const __m256i x = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(a));
    const __m256i y = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(b));
    return second ? _mm256_unpackhi_epi16(x, y) : _mm256_unpacklo_epi16(x, y);
  } else {
    const __m128i x = _mm_loadu_si128(reinterpret_cast<const __m128i*>(a));
    const __m128i y = _mm_loadu_si128(reinterpret_cast<const __m128i*>(b));
    return _mm256_set_m128i(_mm_unpackhi_epi16(x, y), _mm_unpacklo_epi16(x, y));
  }
}

// Rows of some poses, 32 a block or 16 where not whole. Of two columns interleaved, even bytes are pairs of one
// column's even row and the other's, odd bytes of odd rows. So sums lie in a wrong order until they are stored.
// Registers are too few for both halves of many poses: `part` is the first of `parts`, and there is one where not
// whole.
template <bool whole, int blocks, int part, int parts, int poses>
void add_up(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::size_t first_pose,
            const std::uint8_t* ahead, std::int32_t* sums) {
  const __m256i even = _mm256_set1_epi16(255);
  __m256i sum[poses][2 * parts * blocks];
  for (int p = 0; p < poses; ++p)
    for (__m256i& s : sum[p]) s = _mm256_set1_epi32(static_cast<int>(active.start[first_pose + p]));
  const std::uint32_t* place = active.places;
  const std::int16_t* inputs = active.inputs + 4 * first_pose;
  for (std::size_t k = 0; k < active.count; k += 4, place += 4, inputs += 4 * active.poses) {
    if (ahead)
      for (int i = 0; i < 4; ++i) __builtin_prefetch(ahead + place[i] * rows);
    for (int pair = 0; pair < 4; pair += 2) {
      const std::uint8_t *a = digits + place[pair] * rows, *b = digits + place[pair + 1] * rows;
      for (int block = 0; block < blocks; ++block) {
        __m256i weights[2 * parts];
        for (int i = 0; i < parts; ++i) {
          const __m256i both = interleave<whole>(a + 32 * block, b + 32 * block, part + i > 0);
          weights[2 * i] = _mm256_and_si256(both, even);
          weights[2 * i + 1] = _mm256_srli_epi16(both, 8);
        }
        for (int p = 0; p < poses; ++p) {
          int numbers;
          __builtin_memcpy(&numbers, inputs + 4 * p + pair, sizeof numbers);
          const __m256i input = _mm256_set1_epi32(numbers);
          __m256i* s = sum[p] + 2 * parts * block;
          for (int i = 0; i < 2 * parts; ++i) s[i] = multiply_add(s[i], weights[i], input);
        }
      }
    }
  }
  for (int p = 0; p < poses; ++p)
    for (int block = 0; block < blocks; ++block)
      for (int i = 0; i < parts; ++i) {
        const __m256i* s = sum[p] + 2 * parts * block + 2 * i;
        const __m256i low = _mm256_unpacklo_epi32(s[0], s[1]), high = _mm256_unpackhi_epi32(s[0], s[1]);
        auto* to = reinterpret_cast<__m256i*>(sums + panel_rows * (first_pose + p) + 32 * block + 8 * (part + i));
        _mm256_storeu_si256(to, _mm256_permute2x128_si256(low, high, 0x20));
        _mm256_storeu_si256(to + (whole ? 2 : 1), _mm256_permute2x128_si256(low, high, 0x31));
      }
}

// All poses of a block, four at once.
template <bool whole>
void add_up_block(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, const std::uint8_t* ahead,
                  std::int32_t* sums) {
  for (std::size_t pose = 0; pose < block_poses; pose += 4) {
    add_up<whole, 1, 0, 1, 4>(digits, rows, active, pose, pose == 0 ? ahead : nullptr, sums);
    if constexpr (whole) add_up<whole, 1, 1, 1, 4>(digits, rows, active, pose, nullptr, sums);
  }
}

void block_sums(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::int32_t* sums) {
  std::size_t r = 0;
  const std::uint8_t* ahead = active.ahead;
  for (; r + 32 <= rows; r += 32, ahead = nullptr) add_up_block<true>(digits + r, rows, active, ahead, sums + r);
  if (r < rows) add_up_block<false>(digits + r, rows, active, ahead, sums + r);
}
