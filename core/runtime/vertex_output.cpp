#include "runtime/vertex_output.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace fb::runtime {
namespace {

#if defined(__SSE2__)
// Writes four vertices from v on, which are three vectors, by store(address, vector).
template <class IndexOf, class Store>
void write_four(const float* rows, std::size_t v, float* to, const IndexOf& index_of, const Store& store) {
  const __m128 a = _mm_loadu_ps(rows + 3 * index_of(v)), b = _mm_loadu_ps(rows + 3 * index_of(v + 1));
  const __m128 c = _mm_loadu_ps(rows + 3 * index_of(v + 2)), d = _mm_loadu_ps(rows + 3 * index_of(v + 3));
  const __m128 az_bx = _mm_shuffle_ps(a, b, _MM_SHUFFLE(0, 0, 2, 2));  // z z x x
  const __m128 cz_dx = _mm_shuffle_ps(c, d, _MM_SHUFFLE(0, 0, 2, 2));
  store(to + 3 * v, _mm_shuffle_ps(a, az_bx, _MM_SHUFFLE(2, 0, 1, 0)));
  store(to + 3 * v + 4, _mm_shuffle_ps(b, c, _MM_SHUFFLE(1, 0, 2, 1)));
  store(to + 3 * v + 8, _mm_shuffle_ps(cz_dx, d, _MM_SHUFFLE(2, 1, 2, 0)));
}
#endif

// Writes vertices begin..end - 1. index_of(v): the index in `rows` of vertex v. Without gaps, four numbers are copied,
// which is one instruction; the next vertex overwrites the fourth.
template <class Number, class IndexOf>
void copy(const Number* rows, VertexRange range, std::size_t stride, Number* to, const IndexOf& index_of) {
  if (range.begin == range.end) return;
  const std::size_t last = range.end - 1;
  std::size_t v = range.begin;
  if (stride == 3) {
#if defined(__SSE2__)
    if constexpr (std::is_same_v<Number, float>)
      for (; v + 4 <= range.end; v += 4)
        write_four(rows, v, to, index_of, [](float* at, __m128 vector) { _mm_storeu_ps(at, vector); });
#endif
#pragma GCC unroll 4
    for (; v < last; ++v) std::memcpy(to + 3 * v, rows + 3 * index_of(v), 4 * sizeof(Number));
  } else {
    for (; v < last; ++v) std::memcpy(to + v * stride, rows + 3 * index_of(v), 3 * sizeof(Number));
  }
  if (v == last) std::memcpy(to + last * stride, rows + 3 * index_of(last), 3 * sizeof(Number));
}

#if defined(__SSE2__)
// Non-temporal stores, of aligned vectors.
template <class IndexOf>
void stream(const float* rows, VertexRange range, float* to, const IndexOf& index_of) {
  std::size_t v = range.begin;
  const std::size_t vertices = range.end;
  for (; v < vertices && reinterpret_cast<std::uintptr_t>(to + 3 * v) % 16 != 0; ++v)
    std::memcpy(to + 3 * v, rows + 3 * index_of(v), 3 * sizeof(float));
  for (; v + 4 <= vertices; v += 4)
    write_four(rows, v, to, index_of, [](float* at, __m128 vector) { _mm_stream_ps(at, vector); });
  for (; v < vertices; ++v) std::memcpy(to + 3 * v, rows + 3 * index_of(v), 3 * sizeof(float));
  _mm_sfence();
}
#endif

}  // namespace

// In the order of rows, because a vertex of halves is then copied by one instruction, too. Kernels read and write whole
// vectors.
void VertexWriter::convert_to_halves(const PoseKernels& kernels, std::size_t count) const {
  constexpr std::size_t chunk = 16 * padding;
  float floats[chunk];
  for (std::size_t first = 0; first < count; first += chunk) {
    const float* from = rows_ + first;
    const std::size_t numbers = std::min(chunk, count - first);
    if (rest_ || numbers < chunk) {
      for (std::size_t i = 0; i < numbers; ++i) floats[i] = rest_ ? from[i] - rest_[first + i] : from[i];
      std::fill(floats + numbers, floats + chunk, 0.0f);
      from = floats;
    }
    kernels.convert_to_half(from, halves_ + first, numbers);
  }
}

template <class IndexOf>
void VertexWriter::write_range(VertexRange range, const IndexOf& index_of) const {
  const std::size_t stride = output_.vertex_stride;
  if (output_.format == NumberFormat::float16)
    return copy<std::uint16_t>(halves_, range, stride, static_cast<std::uint16_t*>(output_.first), index_of);
  auto* const to = static_cast<float*>(output_.first);
  if (rest_) {
    for (std::size_t v = range.begin; v < range.end; ++v)
      for (std::size_t axis = 0, from = 3 * index_of(v); axis < 3; ++axis, ++from)
        to[v * stride + axis] = rows_[from] - rest_[from];
    return;
  }
#if defined(__SSE2__)
  if (output_.streamed && stride == 3) return stream(rows_, range, to, index_of);
#endif
  copy(rows_, range, stride, to, index_of);
}

void VertexWriter::write(VertexRange range) const {
  const bool floats = output_.format == NumberFormat::float32;
  if (index_.empty() && floats && output_.vertex_stride == 3 && !rest_ && !output_.streamed)
    std::memcpy(static_cast<float*>(output_.first) + 3 * std::size_t(range.begin), rows_ + 3 * std::size_t(range.begin),
                3 * std::size_t(range.end - range.begin) * sizeof(float));
  else if (index_.empty())
    write_range(range, [](std::size_t v) { return v; });
  else
    write_range(range, [&](std::size_t v) { return std::size_t(index_[v]); });
}

namespace {

// vertices[3 i ..] goes to the place of vertex first + i.
template <class Number>
void scatter(const Number* vertices, std::size_t count, std::size_t first, const std::uint32_t* places,
             const VertexOutput& output) {
  auto* const to = static_cast<Number*>(output.first);
  const std::size_t stride = output.vertex_stride;
  if (!places && stride == 3) {
    std::memcpy(to + 3 * first, vertices, 3 * count * sizeof(Number));
  } else if (!places) {
    for (std::size_t i = 0; i < count; ++i)
      std::memcpy(to + (first + i) * stride, vertices + 3 * i, 3 * sizeof(Number));
  } else {
#pragma GCC unroll 4
    for (std::size_t i = 0; i < count; ++i)
      std::memcpy(to + places[first + i] * stride, vertices + 3 * i, 3 * sizeof(Number));
  }
}

}  // namespace

void scatter_vertices(const PoseKernels& kernels, const float* rows, const float* rest, VertexRange range,
                      const std::uint32_t* places, const VertexOutput& output) {
  const bool halves = output.format == NumberFormat::float16;
  if (!rest && !halves) return scatter(rows, range.end - range.begin, range.begin, places, output);
  constexpr std::size_t chunk = 64;  // vertices
  float floats[3 * chunk + padding] = {};
  std::uint16_t converted[3 * chunk + padding];
  for (std::size_t v = range.begin; v < range.end; v += chunk, rows += 3 * chunk) {
    const std::size_t count = std::min<std::size_t>(chunk, range.end - v);
    for (std::size_t i = 0; i < 3 * count; ++i) floats[i] = rest ? rows[i] - rest[i] : rows[i];
    if (rest) rest += 3 * chunk;
    if (!halves) {
      scatter(floats, count, v, places, output);
      continue;
    }
    kernels.convert_to_half(floats, converted, 3 * count);
    scatter<std::uint16_t>(converted, count, v, places, output);
  }
}

}  // namespace fb::runtime
