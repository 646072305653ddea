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

// Writes vertices from `rows`, which holds 3 floats a vertex in an order of its own and is readable one float beyond.
// rest: laid out like rows and subtracted from them; null: nothing is. index[v]: where vertex v of the output's order
// is in rows; empty if both orders are the same. halves: for an output of halves, room for those of all rows, and
// `padding` more. Refers to its arguments.
class VertexWriter {
 public:
  VertexWriter(const PoseKernels& kernels, std::span<const float> rows, const float* rest,
               std::span<const std::uint32_t> index, const VertexOutput& output, std::uint16_t* halves)
      : rows_(rows.data()), rest_(rest), halves_(halves), index_(index), output_(output) {
    if (output.format == NumberFormat::float16) convert_to_halves(kernels, rows.size());
  }

  // Some vertices, in the output's order.
  void write(VertexRange range) const;

 private:
  void convert_to_halves(const PoseKernels& kernels, std::size_t count) const;
  template <class IndexOf>
  void write_range(VertexRange range, const IndexOf& index_of) const;

  const float *rows_, *rest_;
  std::uint16_t* halves_;
  std::span<const std::uint32_t> index_;
  const VertexOutput& output_;
};

// Writes vertices `range` of baked order from their rows, 3 floats a vertex of the range, while these are in the
// caches. places[v]: where vertex v of baked order is in the output's order; null if both are the same. rest: of the
// range too, subtracted from the rows; null: nothing is.
void scatter_vertices(const PoseKernels& kernels, const float* rows, const float* rest, VertexRange range,
                      const std::uint32_t* places, const VertexOutput& output);

}  // namespace fb::runtime
