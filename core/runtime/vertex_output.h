// Writing vertex attributes (positions, normals, tangents) to the caller's buffers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "runtime/kernels/pose_kernels.h"
#include "runtime/mesh_layout.h"

namespace fb::runtime {

// See facebaker.h: FB_ORDER_... and FB_FLOAT...
enum class VertexOrder : std::uint32_t { source = 0, baked = 1 };
enum class NumberFormat : std::uint32_t { float32 = 0, float16 = 1 };

// A buffer for three numbers a vertex. Those of vertex v begin at first + v * vertex_stride numbers; the gaps between
// vertices are not written. Aligned to the number type.
struct VertexOutput {
  void* first = nullptr;  // null: no output
  std::size_t vertex_stride = 3;
  VertexOrder order = VertexOrder::source;
  NumberFormat format = NumberFormat::float32;
  bool streamed = false;  // non-temporal stores, where the processor has them and the numbers are floats without gaps
};

// Writes vertices from `rows`, which holds 3 floats a vertex in baked order and is readable one float beyond.
// baked_index[v]: the index of source vertex v in baked order; empty if both orders are the same. `halves`: a buffer of
// as many numbers as `rows` has. Refers to its arguments.
class VertexWriter {
 public:
  VertexWriter(const PoseKernels& kernels, const float* rows, std::span<const std::uint32_t> baked_index,
               std::uint16_t* halves, const VertexOutput& output)
      : kernels_(kernels), rows_(rows), baked_index_(baked_index), halves_(halves), output_(output) {}

  // Some vertices, given in the source's order and in baked order.
  void write(VertexRange source, std::span<const VertexRange> baked) const;

 private:
  template <class Number>
  void write_numbers(const Number* rows, VertexRange source, std::span<const VertexRange> baked) const;

  const PoseKernels& kernels_;
  const float* rows_;
  std::span<const std::uint32_t> baked_index_;
  std::uint16_t* halves_;
  const VertexOutput& output_;
};

// The same of displacements: rows less `rest`, which is laid out like them.
class DisplacementWriter {
 public:
  DisplacementWriter(const PoseKernels& kernels, const float* rows, const float* rest,
                     std::span<const std::uint32_t> baked_index, const VertexOutput& output)
      : kernels_(kernels), rows_(rows), rest_(rest), baked_index_(baked_index), output_(output) {}

  void write(VertexRange source, std::span<const VertexRange> baked) const;

 private:
  template <class IndexOf>
  void write_range(VertexRange range, IndexOf&& index_of) const;

  const PoseKernels& kernels_;
  const float *rows_, *rest_;
  std::span<const std::uint32_t> baked_index_;
  const VertexOutput& output_;
};

}  // namespace fb::runtime
