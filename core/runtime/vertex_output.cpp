#include "runtime/vertex_output.h"

#include <cstring>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace fb::runtime {
namespace {

// Writes vertices begin..end - 1. index_of(v): the index in `rows` of vertex v. Without gaps, four numbers are copied,
// which is one instruction; the next vertex overwrites the fourth.
template <class IndexOf>
void copy(const float* rows, VertexRange range, std::size_t stride, float* to, const IndexOf& index_of) {
  if (range.begin == range.end) return;
  const std::size_t last = range.end - 1;
  if (stride == 3)
#pragma GCC unroll 4
    for (std::size_t v = range.begin; v < last; ++v) std::memcpy(to + 3 * v, rows + 3 * index_of(v), 4 * sizeof(float));
  else
    for (std::size_t v = range.begin; v < last; ++v)
      std::memcpy(to + v * stride, rows + 3 * index_of(v), 3 * sizeof(float));
  std::memcpy(to + last * stride, rows + 3 * index_of(last), 3 * sizeof(float));
}

#if defined(__SSE2__)
// Non-temporal stores of aligned vectors: four vertices are three vectors.
template <class IndexOf>
void stream(const float* rows, VertexRange range, float* to, const IndexOf& index_of) {
  std::size_t v = range.begin;
  const std::size_t vertices = range.end;
  for (; v < vertices && reinterpret_cast<std::uintptr_t>(to + 3 * v) % 16 != 0; ++v)
    std::memcpy(to + 3 * v, rows + 3 * index_of(v), 3 * sizeof(float));
  for (; v + 4 <= vertices; v += 4) {
    const __m128 a = _mm_loadu_ps(rows + 3 * index_of(v)), b = _mm_loadu_ps(rows + 3 * index_of(v + 1));
    const __m128 c = _mm_loadu_ps(rows + 3 * index_of(v + 2)), d = _mm_loadu_ps(rows + 3 * index_of(v + 3));
    const __m128 az_bx = _mm_shuffle_ps(a, b, _MM_SHUFFLE(0, 0, 2, 2));  // z z x x
    const __m128 cz_dx = _mm_shuffle_ps(c, d, _MM_SHUFFLE(0, 0, 2, 2));
    _mm_stream_ps(to + 3 * v, _mm_shuffle_ps(a, az_bx, _MM_SHUFFLE(2, 0, 1, 0)));
    _mm_stream_ps(to + 3 * v + 4, _mm_shuffle_ps(b, c, _MM_SHUFFLE(1, 0, 2, 1)));
    _mm_stream_ps(to + 3 * v + 8, _mm_shuffle_ps(cz_dx, d, _MM_SHUFFLE(2, 1, 2, 0)));
  }
  for (; v < vertices; ++v) std::memcpy(to + 3 * v, rows + 3 * index_of(v), 3 * sizeof(float));
  _mm_sfence();
}
#endif

}  // namespace

// Displacements and halves: some vertices at a time are collected, converted and written.
template <class IndexOf>
void VertexWriter::write_chunks(VertexRange range, const IndexOf& index_of) const {
  constexpr std::size_t chunk = 64;
  float floats[3 * chunk + padding] = {}, rest[3 * chunk + padding] = {};  // kernels read and write whole vectors
  std::uint16_t halves[3 * chunk + padding];
  const bool half = output_.format == NumberFormat::float16;
  const std::size_t size = half ? sizeof(std::uint16_t) : sizeof(float);
  for (std::size_t first = range.begin; first < range.end; first += chunk) {
    const std::size_t count = range.end - first < chunk ? range.end - first : chunk;
    const auto collect = [&](const float* from, float* to) {
#pragma GCC unroll 4
      for (std::size_t i = 0; i < count; ++i, to += 3)
        std::memcpy(to, from + 3 * index_of(first + i), 4 * sizeof(float));
    };
    collect(rows_, floats);
    if (rest_) {
      collect(rest_, rest);
      for (std::size_t i = 0; i < 3 * count; ++i) floats[i] -= rest[i];
    }
    if (half) kernels_.convert_to_half(floats, halves, 3 * count);
    auto* to = static_cast<std::byte*>(output_.first) + first * output_.vertex_stride * size;
    const auto* from = half ? reinterpret_cast<const std::byte*>(halves) : reinterpret_cast<const std::byte*>(floats);
    if (output_.vertex_stride == 3) {
      std::memcpy(to, from, 3 * count * size);
      continue;
    }
    for (std::size_t i = 0; i < count; ++i, to += output_.vertex_stride * size, from += 3 * size)
      std::memcpy(to, from, 3 * size);
  }
}

template <class IndexOf>
void VertexWriter::write_range(VertexRange range, const IndexOf& index_of) const {
  if (rest_ || output_.format == NumberFormat::float16) return write_chunks(range, index_of);
  auto* const to = static_cast<float*>(output_.first);
#if defined(__SSE2__)
  if (output_.streamed && output_.vertex_stride == 3) return stream(rows_, range, to, index_of);
#endif
  copy(rows_, range, output_.vertex_stride, to, index_of);
}

void VertexWriter::write(VertexRange range) const {
  if (index_.empty())
    write_range(range, [](std::size_t v) { return v; });
  else
    write_range(range, [&](std::size_t v) { return std::size_t(index_[v]); });
}

}  // namespace fb::runtime
