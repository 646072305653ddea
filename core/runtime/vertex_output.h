// How what was computed leaves: in which order, as which numbers, how far apart.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "runtime/kernels/panel_kernels.h"

namespace fb::runtime {

enum class VertexOrder : std::uint32_t { source = 0, baked = 1 };
enum class NumberFormat : std::uint32_t { float32 = 0, float16 = 1 };

// Three numbers a vertex: those of vertex v begin at first + v * vertex_stride numbers. What lies between is not
// touched. Aligned as its numbers are.
struct VertexOutput {
  void* first = nullptr;  // null: not wanted
  std::size_t vertex_stride = 3;
  VertexOrder order = VertexOrder::source;
  NumberFormat format = NumberFormat::float32;
  bool streamed = false;  // past the caches, where the processor can and the numbers are floats without gaps
};

// Writes `vertices` vertices that lie in baked order in `rows`, which has a float more than theirs. place_of[v]: the
// place of the source's vertex v in that order; empty if both are the same. `halves`: as many as `rows` has floats.
void write_vertices(const PoseKernels& kernels, const float* rows, std::size_t vertices,
                    std::span<const std::uint32_t> place_of, std::uint16_t* halves, const VertexOutput& output);

}  // namespace fb::runtime
