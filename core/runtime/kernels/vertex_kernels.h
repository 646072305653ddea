// Normals and tangents of as many vertices at a time as a vector has lanes: included by float_kernels.h inside an
// unnamed namespace.

// Shuffles fours of lanes alike; i to l: of the first four of a, 0 to 3, or of b, 4 to 7.
#define FB_LANE(i) ((i) < 4 ? (i) : (i) + int(lanes) - 4)
#if defined(__AVX__)
#define FB_SHUFFLE(a, b, i, j, k, l)                                                                            \
  __builtin_shufflevector(a, b, FB_LANE(i), FB_LANE(j), FB_LANE(k), FB_LANE(l), FB_LANE(i) + 4, FB_LANE(j) + 4, \
                          FB_LANE(k) + 4, FB_LANE(l) + 4)
#else
#define FB_SHUFFLE(a, b, i, j, k, l) __builtin_shufflevector(a, b, i, j, k, l)
#endif

using Four = float __attribute__((vector_size(16)));

// Four floats from one address, or from each of two.
[[gnu::always_inline]] inline void load(Floats& to, const float* first, [[maybe_unused]] const float* second) {
#if defined(__AVX__)  // written with vectors, GCC would merge two registers
  to = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(first)), _mm_loadu_ps(second), 1);
#else
  __builtin_memcpy(&to, first, sizeof to);
#endif
}

constexpr std::size_t fours = lanes / 4;

// The cross product a x b is computed as a * (b rotated) - (a rotated) * b, which is rotated.
void quad_areas(const Quad* quads, std::size_t count, const float* rows, float scale, float* vectors) {
  for (std::size_t i = 0; i < count; i += fours) {
    const std::uint32_t *const first = quads[i].offset, *const second = quads[i + fours - 1].offset;
    Floats corner[4];
    for (int k = 0; k < 4; ++k) load(corner[k], rows + first[k], rows + second[k]);
    const Floats a = (corner[2] - corner[0]) * scale, b = (corner[3] - corner[1]) * scale;
    const Floats area = a * FB_SHUFFLE(b, b, 1, 2, 0, 3) - FB_SHUFFLE(a, a, 1, 2, 0, 3) * b;
    __builtin_memcpy(vectors + 4 * i, &area, sizeof area);
  }
}

void quad_integrals(const Quad* quads, const QuadWeights* weights, std::size_t count, const float* rows,
                    float* vectors) {
  for (std::size_t i = 0; i < count; ++i) {
    Four corner[4], sum = {};
    for (int k = 0; k < 4; ++k) __builtin_memcpy(corner + k, rows + quads[i].offset[k], sizeof *corner);
    for (int k = 1; k < 4; ++k) sum += weights[i].of[k - 1] * (corner[k] - corner[0]);
    __builtin_memcpy(vectors + 4 * i, &sum, sizeof sum);
  }
}

// Numbers 0, 1 and 2 of vectors k, and k + 4 behind them, in of[k], for k < 4, to those of all vectors each.
[[gnu::always_inline]] inline void split_axes(const Floats (&of)[4], Floats& a, Floats& b, Floats& c) {
  const Floats ab01 = FB_SHUFFLE(of[0], of[1], 0, 4, 1, 5), ab23 = FB_SHUFFLE(of[2], of[3], 0, 4, 1, 5);
  const Floats c01 = FB_SHUFFLE(of[0], of[1], 2, 6, 2, 6), c23 = FB_SHUFFLE(of[2], of[3], 2, 6, 2, 6);
  a = FB_SHUFFLE(ab01, ab23, 0, 1, 4, 5);
  b = FB_SHUFFLE(ab01, ab23, 2, 3, 6, 7);
  c = FB_SHUFFLE(c01, c23, 0, 1, 4, 5);
}

// As one memcpy, GCC would write to the stack and read from there.
[[gnu::always_inline]] inline void store_three(Four vector, float* to) {
  __builtin_memcpy(to, &vector, 2 * sizeof(float));
#if defined(__AVX__)
  const int third = _mm_extract_ps(vector, 2);
#else
  const float third = vector[2];
#endif
  __builtin_memcpy(to + 2, &third, sizeof third);
}

// The reverse: writes vectors of three floats and, unless they are to be exact, a float behind them.
template <bool exact = false>
[[gnu::always_inline]] inline void store_vectors(const Floats& x, const Floats& y, const Floats& z, float* to) {
  const Floats xy01 = FB_SHUFFLE(x, y, 0, 4, 1, 5), xy23 = FB_SHUFFLE(x, y, 2, 6, 3, 7);
  const Floats of[4] = {FB_SHUFFLE(xy01, z, 0, 1, 4, 4), FB_SHUFFLE(xy01, z, 2, 3, 5, 5),
                        FB_SHUFFLE(xy23, z, 0, 1, 6, 6), FB_SHUFFLE(xy23, z, 2, 3, 7, 7)};
  for (std::size_t i = 0; i < fours; ++i)
    for (std::size_t k = 0; k < 4; ++k) {
      const char* const vector = reinterpret_cast<const char*>(of + k) + i * sizeof(Four);
      float* const at = to + 3 * (4 * i + k);
      if (exact && 4 * i + k + 1 == lanes) {
        Four last;
        __builtin_memcpy(&last, vector, sizeof last);
        store_three(last, at);
      } else {
        __builtin_memcpy(at, vector, sizeof(Four));
      }
    }
}

[[gnu::always_inline]] inline void square_roots(const Floats& of, Floats& roots) {
  float numbers[lanes];
  __builtin_memcpy(numbers, &of, sizeof of);
  for (float& number : numbers) number = __builtin_sqrtf(number);
  __builtin_memcpy(&roots, numbers, sizeof roots);
}

// value where mask is set, else +0.
[[gnu::always_inline]] inline void keep(const Integers& mask, Floats& value) {
  value = (Floats)((Integers)value & mask);
}

// Adds up the polygons' vectors around each vertex and calls finish(vertex, sum, x, y, z) to make a unit vector of
// their numbers 0, 1 and 2. Always adds four: most vertices have four polygons, and a branch would be unpredictable.
template <class Finish>
[[gnu::always_inline]] inline void for_vertices(const PolygonsAround& around, const float* vectors, float* results,
                                                const Finish& finish) {
  constexpr auto second = static_cast<std::uint32_t>(lanes - 4);
  for (std::uint32_t vertex = around.begin; vertex < around.end; vertex += lanes) {
    const FirstPolygons* const of = around.first + vertex;
    Floats sum[4];
    for (std::size_t k = 0; k < 4; ++k) {
      Floats polygon[4];
      for (std::size_t i = 0; i < 4; ++i)
        load(polygon[i], vectors + of[k].offset[i], vectors + of[k + second].offset[i]);
      sum[k] = ((polygon[0] + polygon[1]) + polygon[2]) + polygon[3];
    }
    const std::uint32_t* const further = around.further_begin + vertex / FurtherPolygons::vertices;
    for (std::uint32_t f = further[0]; f < further[1]; ++f) {
      const std::uint32_t* const offset = around.further[f].offset + vertex % FurtherPolygons::vertices;
      for (std::size_t k = 0; k < 4; ++k) {
        Floats polygon;
        load(polygon, vectors + offset[k], vectors + offset[k + second]);
        sum[k] += polygon;
      }
    }
    Floats a, b, c;
    split_axes(sum, a, b, c);
    finish(vertex, a, b, c);
    if (vertex + lanes < around.end) {
      store_vectors(a, b, c, results + 3 * std::size_t(vertex));
    } else {  // nothing beyond the last one is written
      float last[3 * lanes + 1];
      store_vectors(a, b, c, last);
      __builtin_memcpy(results + 3 * std::size_t(vertex), last, 3 * (around.end - vertex) * sizeof(float));
    }
  }
}

void vertex_normals(const PolygonsAround& around, const float* areas, float* normals) {
  for_vertices(around, areas, normals, [](std::uint32_t, Floats& a, Floats& b, Floats& c) {
    Floats z = a, x = b, y = c, length;
    const Floats square = x * x + y * y + z * z;
    square_roots(square, length);
    const Floats scale = 1.0f / length;
    const Integers valid = (Integers)(square > 0.0f) & (Integers)(square <= 0x1.fffffep127f);
    a = x * scale;
    b = y * scale;
    c = z * scale;
    keep(valid, a);
    keep(valid, b);
    keep(valid, c);
  });
}

void vertex_tangents(const PolygonsAround& around, const float* integrals, const float* normals, float* tangents) {
  for_vertices(around, integrals, tangents, [&](std::uint32_t v, Floats& x, Floats& y, Floats& z) {
    Floats normal[4], nx, ny, nz, root;
    for (std::size_t k = 0; k < 4; ++k) load(normal[k], normals + 3 * (v + k), normals + 3 * (v + k + lanes - 4));
    split_axes(normal, nx, ny, nz);
    const Floats along = (x * nx + y * ny) + z * nz;
    x -= along * nx;
    y -= along * ny;
    z -= along * nz;
    const Integers no_sign = (Integers){} + 0x7fffffff;
    const Floats ax = (Floats)((Integers)x & no_sign), ay = (Floats)((Integers)y & no_sign),
                 az = (Floats)((Integers)z & no_sign);
    const Floats xy = ax < ay ? ay : ax, size = xy < az ? az : xy;
    const Integers has_normal = (Integers)(nx != 0.0f) | (Integers)(ny != 0.0f) | (Integers)(nz != 0.0f);
    const Integers finite = (Integers)(x - x == 0.0f) & (Integers)(y - y == 0.0f) & (Integers)(z - z == 0.0f);
    const Integers valid = has_normal & finite & (Integers)(size > 0.0f);
    // Divided by their largest number first, so that squares neither overflow nor underflow.
    x /= size;
    y /= size;
    z /= size;
    square_roots((x * x + y * y) + z * z, root);
    x /= root;
    y /= root;
    z /= root;
    keep(valid, x);
    keep(valid, y);
    keep(valid, z);
  });
}

// The columns of a matrix, one, two or four in a register.
#if defined(__AVX512F__)
constexpr std::size_t column_lanes = 16;
#else
constexpr std::size_t column_lanes = lanes;
#endif
using Columns = float __attribute__((vector_size(4 * column_lanes)));

// The columns of a sum of matrices times x, y, z and 1: (x times 0 + y times 1) + (z times 2 + column 3).
[[gnu::always_inline]] inline Four times_position(const Columns (&blend)[joint_matrix_floats / column_lanes], Four p) {
#if defined(__AVX512F__)
  const __m512i axes = _mm512_set_epi32(3, 3, 3, 3, 2, 2, 2, 2, 1, 1, 1, 1, 0, 0, 0, 0);
  const __m512 position = _mm512_permutexvar_ps(axes, _mm512_castps128_ps512(p));
  const __m512 xyz1 = _mm512_mask_mul_ps(blend[0], 0xfff, blend[0], position);
  const __m256 xy = _mm512_castps512_ps256(xyz1),
               z1 = _mm256_castpd_ps(_mm512_extractf64x4_pd(_mm512_castps_pd(xyz1), 1));
  return _mm_add_ps(_mm_add_ps(_mm256_castps256_ps128(xy), _mm256_extractf128_ps(xy, 1)),
                    _mm_add_ps(_mm256_castps256_ps128(z1), _mm256_extractf128_ps(z1, 1)));
#elif defined(__AVX__)
  const Floats ones = (Floats){} + 1.0f, p2 = __builtin_shufflevector(p, p, 0, 1, 2, 3, 0, 1, 2, 3);
  const Floats xy = blend[0] * __builtin_shufflevector(p2, ones, 0, 0, 0, 0, 1, 1, 1, 1),
               z1 = blend[1] * __builtin_shufflevector(p2, ones, 2, 2, 2, 2, 8, 8, 8, 8);
  return (__builtin_shufflevector(xy, xy, 0, 1, 2, 3) + __builtin_shufflevector(xy, xy, 4, 5, 6, 7)) +
         (__builtin_shufflevector(z1, z1, 0, 1, 2, 3) + __builtin_shufflevector(z1, z1, 4, 5, 6, 7));
#else
  return (blend[0] * p[0] + blend[1] * p[1]) + (blend[2] * p[2] + blend[3]);
#endif
}

// What is 0 or NaN counts as -0, which changes nothing.
[[gnu::always_inline]] inline void move_by(Four offset, Four& position) {
#if defined(__AVX__)
  const Four moves = _mm_cmp_ps(offset, _mm_setzero_ps(), _CMP_NEQ_OQ);
  position += _mm_blendv_ps(_mm_set1_ps(-0.0f), offset, moves);
#else
  using FourIntegers = std::int32_t __attribute__((vector_size(16)));
  const FourIntegers moves = (FourIntegers)(offset < 0.0f) | (FourIntegers)(offset > 0.0f);
  const FourIntegers sign = (FourIntegers){} + INT32_MIN;
  position += (Four)(((FourIntegers)offset & moves) | (sign & ~moves));
#endif
}

void skin_vertices(const SkinTable& skin, std::uint32_t begin, std::uint32_t end, const float* matrices, float* rows) {
  for (std::uint32_t v = begin; v < end; ++v) {
    const JointInfluence* influence = skin.influences + skin.first[v];
    const JointInfluence* const last = skin.influences + skin.first[v + 1];
    Columns blend[joint_matrix_floats / column_lanes] = {};
    for (; influence < last; ++influence)
      for (std::size_t k = 0; k < joint_matrix_floats / column_lanes; ++k) {
        Columns part;
        __builtin_memcpy(&part, matrices + influence->offset + k * column_lanes, sizeof part);
        blend[k] += influence->weight * part;
      }
    float* const at = rows + 3 * std::size_t(v);
    Four position;
    __builtin_memcpy(&position, at, sizeof position);
    move_by(times_position(blend, position), position);
    store_three(position, at);
  }
}

// (x times column 0 + y times column 1) + (z times column 2 + column 3) of a row of the sum of matrices.
[[gnu::always_inline]] inline Floats offset_along(std::size_t row, const SkinGroup& group, const float* weights,
                                                  const float* matrices, const Floats& x, const Floats& y,
                                                  const Floats& z) {
  Floats column[4] = {};
  for (std::uint32_t j = 0; j < group.joints; ++j, weights += SkinGroup::vertices) {
    Floats weight;
    __builtin_memcpy(&weight, weights, sizeof weight);
    for (std::size_t c = 0; c < 4; ++c) column[c] += weight * matrices[group.offset[j] + 4 * c + row];
  }
  return (column[0] * x + column[1] * y) + (column[2] * z + column[3]);
}

// What is 0 or NaN counts as -0, as in move_by.
[[gnu::always_inline]] inline void move_all_by(const Floats& offset, Floats& coordinates) {
  const Integers moves = (Integers)(offset < 0.0f) | (Integers)(offset > 0.0f), sign = (Integers){} + INT32_MIN;
  coordinates += (Floats)(((Integers)offset & moves) | (sign & ~moves));
}

void skin_groups(const SkinGroup* groups, std::size_t count, const float* weights, const float* matrices, float* rows) {
  for (const SkinGroup* group = groups; group < groups + count; ++group)
    for (std::size_t k = 0; k < SkinGroup::vertices; k += lanes) {
      float* const at = rows + group->first_row + 3 * k;
      Floats four[4], x, y, z;
      for (std::size_t i = 0; i < 4; ++i) load(four[i], at + 3 * i, at + 3 * (i + lanes - 4));
      split_axes(four, x, y, z);
      const float* const of = weights + group->first_weight + k;
      const Floats moved[3] = {offset_along(0, *group, of, matrices, x, y, z),
                               offset_along(1, *group, of, matrices, x, y, z),
                               offset_along(2, *group, of, matrices, x, y, z)};
      move_all_by(moved[0], x);
      move_all_by(moved[1], y);
      move_all_by(moved[2], z);
      store_vectors<true>(x, y, z, at);
    }
}

#undef FB_SHUFFLE
#undef FB_LANE
