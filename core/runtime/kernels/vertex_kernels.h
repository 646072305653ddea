// Normals and tangents of eight vertices at a time, in vectors that compilers map to those of each instruction set:
// included by float_kernels.h inside an unnamed namespace.

using FourFloats = float __attribute__((vector_size(16)));
using EightFloats = float __attribute__((vector_size(32)));
using EightMasks = std::int32_t __attribute__((vector_size(32)));

// Four floats from each of two addresses.
[[gnu::always_inline]] inline void load_pair(EightFloats& pair, const float* first, const float* last) {
#if defined(__AVX__)  // GCC would merge two registers
  pair = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(first)), _mm_loadu_ps(last), 1);
#else
  FourFloats halves[2];
  __builtin_memcpy(halves, first, sizeof *halves);
  __builtin_memcpy(halves + 1, last, sizeof *halves);
  pair = __builtin_shufflevector(halves[0], halves[1], 0, 1, 2, 3, 4, 5, 6, 7);
#endif
}

// Two quads at a time. The cross product a x b is computed as a * (b rotated) - (a rotated) * b, which is rotated.
void quad_areas(const Quad* quads, std::size_t count, const float* rows, float scale, float* vectors) {
  for (std::size_t i = 0; i < count; i += 2) {
    const std::uint32_t *const first = quads[i].offset, *const last = quads[i + 1].offset;
    EightFloats corner[4];
    for (int k = 0; k < 4; ++k) load_pair(corner[k], rows + first[k], rows + last[k]);
    const EightFloats a = (corner[2] - corner[0]) * scale, b = (corner[3] - corner[1]) * scale;
    const EightFloats rotated_a = __builtin_shufflevector(a, a, 1, 2, 0, 3, 5, 6, 4, 7);
    const EightFloats rotated_b = __builtin_shufflevector(b, b, 1, 2, 0, 3, 5, 6, 4, 7);
    const EightFloats area = a * rotated_b - rotated_a * b;
    __builtin_memcpy(vectors + 4 * i, &area, sizeof area);
  }
}

void quad_integrals(const Quad* quads, const QuadWeights* weights, std::size_t count, const float* rows,
                    float* vectors) {
  for (std::size_t i = 0; i < count; ++i) {
    FourFloats corner[4], sum = {};
    for (int k = 0; k < 4; ++k) __builtin_memcpy(corner + k, rows + quads[i].offset[k], sizeof *corner);
    for (int k = 1; k < 4; ++k) sum += weights[i].of[k - 1] * (corner[k] - corner[0]);
    __builtin_memcpy(vectors + 4 * i, &sum, sizeof sum);
  }
}

// Numbers 0, 1 and 2 of vectors k and k + 4 in of[k], for k < 4, to those of eight vectors each.
[[gnu::always_inline]] inline void split_axes(const EightFloats (&of)[4], EightFloats& a, EightFloats& b,
                                              EightFloats& c) {
  const EightFloats ab01 = __builtin_shufflevector(of[0], of[1], 0, 8, 1, 9, 4, 12, 5, 13);
  const EightFloats ab23 = __builtin_shufflevector(of[2], of[3], 0, 8, 1, 9, 4, 12, 5, 13);
  const EightFloats c01 = __builtin_shufflevector(of[0], of[1], 2, 10, 2, 10, 6, 14, 6, 14);
  const EightFloats c23 = __builtin_shufflevector(of[2], of[3], 2, 10, 2, 10, 6, 14, 6, 14);
  a = __builtin_shufflevector(ab01, ab23, 0, 1, 8, 9, 4, 5, 12, 13);
  b = __builtin_shufflevector(ab01, ab23, 2, 3, 10, 11, 6, 7, 14, 15);
  c = __builtin_shufflevector(c01, c23, 0, 1, 8, 9, 4, 5, 12, 13);
}

// The reverse: writes eight vectors of three floats, and a float behind them.
[[gnu::always_inline]] inline void store_vectors(const EightFloats& x, const EightFloats& y, const EightFloats& z,
                                                 float* to) {
  const EightFloats xy[2] = {__builtin_shufflevector(x, y, 0, 8, 1, 9, 4, 12, 5, 13),
                             __builtin_shufflevector(x, y, 2, 10, 3, 11, 6, 14, 7, 15)};
  const EightFloats of[4] = {__builtin_shufflevector(xy[0], z, 0, 1, 8, 8, 4, 5, 12, 12),
                             __builtin_shufflevector(xy[0], z, 2, 3, 9, 9, 6, 7, 13, 13),
                             __builtin_shufflevector(xy[1], z, 0, 1, 10, 10, 4, 5, 14, 14),
                             __builtin_shufflevector(xy[1], z, 2, 3, 11, 11, 6, 7, 15, 15)};
  for (int k = 0; k < 4; ++k) __builtin_memcpy(to + 3 * k, of + k, sizeof *of / 2);
  for (int k = 0; k < 4; ++k) {
    const FourFloats last = __builtin_shufflevector(of[k], of[k], 4, 5, 6, 7);
    __builtin_memcpy(to + 3 * (4 + k), &last, sizeof last);
  }
}

[[gnu::always_inline]] inline void square_roots(const EightFloats& of, EightFloats& roots) {
  float numbers[8];
  __builtin_memcpy(numbers, &of, sizeof of);
  for (float& number : numbers) number = __builtin_sqrtf(number);
  __builtin_memcpy(&roots, numbers, sizeof roots);
}

// value where mask is set, else +0.
[[gnu::always_inline]] inline void keep(const EightMasks& mask, EightFloats& value) {
  value = (EightFloats)((EightMasks)value & mask);
}

// Adds up the polygons' vectors around each vertex and calls finish(vertex, sum, x, y, z) to make a unit vector of
// their numbers 0, 1 and 2. Always adds four: most vertices have four polygons, and a branch would be unpredictable.
template <class Finish>
[[gnu::always_inline]] inline void for_vertices(const PolygonsAround& around, const float* vectors, float* results,
                                                const Finish& finish) {
  const ExtraPolygon* extra = around.extra;
  for (std::uint32_t vertex = around.begin; vertex < around.end; vertex += 8) {
    const FirstPolygons* const of = around.first + vertex;
    EightFloats sum[4];
    for (int k = 0; k < 4; ++k) {
      EightFloats polygon[4];
      for (int i = 0; i < 4; ++i) load_pair(polygon[i], vectors + of[k].offset[i], vectors + of[k + 4].offset[i]);
      sum[k] = ((polygon[0] + polygon[1]) + polygon[2]) + polygon[3];
    }
    if (extra->vertex < vertex + 8) {
      float sums[8][4];
      for (int k = 0; k < 4; ++k) {
        __builtin_memcpy(sums[k], sum + k, sizeof sums[k]);
        __builtin_memcpy(sums[k + 4], reinterpret_cast<const char*>(sum + k) + sizeof sums[k], sizeof sums[k]);
      }
      for (; extra->vertex < vertex + 8; ++extra)
        for (int i = 0; i < 4; ++i) sums[extra->vertex - vertex][i] += vectors[extra->offset + i];
      for (int k = 0; k < 4; ++k) load_pair(sum[k], sums[k], sums[k + 4]);
    }
    EightFloats a, b, c;
    split_axes(sum, a, b, c);
    finish(vertex, a, b, c);
    if (vertex + 8 < around.end) {
      store_vectors(a, b, c, results + 3 * std::size_t(vertex));
    } else {  // nothing beyond the last one is written
      float last[3 * 8 + 1];
      store_vectors(a, b, c, last);
      __builtin_memcpy(results + 3 * std::size_t(vertex), last, 3 * (around.end - vertex) * sizeof(float));
    }
  }
}

void vertex_normals(const PolygonsAround& around, const float* areas, float* normals) {
  for_vertices(around, areas, normals, [](std::uint32_t, EightFloats& a, EightFloats& b, EightFloats& c) {
    EightFloats z = a, x = b, y = c, length;
    const EightFloats square = x * x + y * y + z * z;
    square_roots(square, length);
    const EightFloats scale = 1.0f / length;
    const EightMasks valid = (EightMasks)(square > 0.0f) & (EightMasks)(square <= 0x1.fffffep127f);
    a = x * scale;
    b = y * scale;
    c = z * scale;
    keep(valid, a);
    keep(valid, b);
    keep(valid, c);
  });
}

void vertex_tangents(const PolygonsAround& around, const float* integrals, const float* normals, float* tangents) {
  for_vertices(around, integrals, tangents, [&](std::uint32_t v, EightFloats& x, EightFloats& y, EightFloats& z) {
    EightFloats normal[4], nx, ny, nz, root;
    for (std::size_t k = 0; k < 4; ++k) load_pair(normal[k], normals + 3 * (v + k), normals + 3 * (v + k + 4));
    split_axes(normal, nx, ny, nz);
    const EightFloats along = (x * nx + y * ny) + z * nz;
    x -= along * nx;
    y -= along * ny;
    z -= along * nz;
    const EightMasks no_sign = (EightMasks){} + 0x7fffffff;
    const EightFloats ax = (EightFloats)((EightMasks)x & no_sign), ay = (EightFloats)((EightMasks)y & no_sign),
                      az = (EightFloats)((EightMasks)z & no_sign);
    const EightFloats xy = ax < ay ? ay : ax, size = xy < az ? az : xy;
    const EightMasks has_normal = (EightMasks)(nx != 0.0f) | (EightMasks)(ny != 0.0f) | (EightMasks)(nz != 0.0f);
    const EightMasks finite = (EightMasks)(x - x == 0.0f) & (EightMasks)(y - y == 0.0f) & (EightMasks)(z - z == 0.0f);
    const EightMasks valid = has_normal & finite & (EightMasks)(size > 0.0f);
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
