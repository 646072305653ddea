#include "runtime/vertex_output.h"

#include <cstring>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace fb::runtime {
namespace {

// Writes vertices begin..end - 1. index_of(v): the index in `rows` of vertex v. Without gaps, four numbers are copied,
// which is one instruction; the next vertex overwrites the fourth.
template <class Number, class IndexOf>
void copy(const Number* rows, VertexRange range, const VertexOutput& output, IndexOf&& index_of) {
  auto* to = static_cast<Number*>(output.first);
  if (range.begin == range.end) return;
  const std::size_t last = range.end - 1;
  if (output.vertex_stride == 3)
#pragma GCC unroll 4
    for (std::size_t v = range.begin; v < last; ++v)
      std::memcpy(to + 3 * v, rows + 3 * index_of(v), 4 * sizeof(Number));
  else
    for (std::size_t v = range.begin; v < last; ++v)
      std::memcpy(to + v * output.vertex_stride, rows + 3 * index_of(v), 3 * sizeof(Number));
  std::memcpy(to + last * output.vertex_stride, rows + 3 * index_of(last), 3 * sizeof(Number));
}

#if defined(__SSE2__)
// Non-temporal stores of aligned vectors: four vertices are three vectors.
template <class IndexOf>
void stream(const float* rows, VertexRange range, float* to, IndexOf&& index_of) {
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

template <class Number, class IndexOf>
void write_range(const Number* rows, VertexRange range, const VertexOutput& output, IndexOf&& index_of) {
#if defined(__SSE2__)
  if constexpr (sizeof(Number) == sizeof(float))
    if (output.streamed && output.vertex_stride == 3)
      return stream(rows, range, static_cast<float*>(output.first), index_of);
#endif
  copy(rows, range, output, index_of);
}

}  // namespace

template <class Number>
void VertexWriter::write_numbers(const Number* rows, VertexRange source, std::span<const VertexRange> baked) const {
  if (!baked_index_.empty() && output_.order == VertexOrder::source)
    write_range(rows, source, output_, [&](std::size_t v) { return std::size_t(baked_index_[v]); });
  else
    for (const VertexRange range : baked) write_range(rows, range, output_, [](std::size_t v) { return v; });
}

template <class IndexOf>
void DisplacementWriter::write_range(VertexRange range, IndexOf&& index_of) const {
  constexpr std::size_t chunk = 64;
  float floats[3 * chunk + padding] = {};  // kernels read and write whole vectors
  std::uint16_t halves[3 * chunk + padding];
  for (std::size_t first = range.begin; first < range.end; first += chunk) {
    const std::size_t count = range.end - first < chunk ? range.end - first : chunk;
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t row = 3 * index_of(first + i), axis = 0; axis < 3; ++axis)
        floats[3 * i + axis] = rows_[row + axis] - rest_[row + axis];
    const bool half = output_.format == NumberFormat::float16;
    if (half) kernels_.convert_to_half(floats, halves, 3 * count);
    const std::size_t size = half ? sizeof(std::uint16_t) : sizeof(float);
    auto* to = static_cast<std::byte*>(output_.first) + first * output_.vertex_stride * size;
    const auto* from = half ? reinterpret_cast<const std::byte*>(halves) : reinterpret_cast<const std::byte*>(floats);
    for (std::size_t i = 0; i < count; ++i, to += output_.vertex_stride * size, from += 3 * size)
      std::memcpy(to, from, 3 * size);
  }
}

void DisplacementWriter::write(VertexRange source, std::span<const VertexRange> baked) const {
  if (!baked_index_.empty() && output_.order == VertexOrder::source)
    write_range(source, [&](std::size_t v) { return std::size_t(baked_index_[v]); });
  else
    for (const VertexRange range : baked) write_range(range, [](std::size_t v) { return v; });
}

void VertexWriter::write(VertexRange source, std::span<const VertexRange> baked) const {
  if (output_.format == NumberFormat::float32) return write_numbers(rows_, source, baked);
  for (const auto [begin, end] : baked)
    kernels_.convert_to_half(rows_ + 3 * std::size_t(begin), halves_ + 3 * std::size_t(begin),
                             3 * std::size_t(end - begin));
  write_numbers(static_cast<const std::uint16_t*>(halves_), source, baked);
}

}  // namespace fb::runtime
