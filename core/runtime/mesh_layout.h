// Where the meshes of a face are among its vertices and row blocks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "model/packed_model.h"
#include "runtime/csr_table.h"

namespace fb::runtime {

// By mesh, 0 for those that are not posed. Empty: all are.
using MeshMask = std::span<const std::uint8_t>;

// Vertices begin..end - 1.
struct VertexRange {
  std::uint32_t begin, end;
};

// The vertices of a row block below `end`, which may be none: a vertex belongs to the block that its first row is in.
inline VertexRange vertices_of_rows(std::uint32_t first_row, std::uint32_t row_count, std::uint32_t end) {
  const std::uint32_t last = (first_row + row_count + 2) / 3;
  return {(first_row + 2) / 3, last < end ? last : end};
}

struct MeshLayout {
  // A face that names no meshes is one.
  MeshLayout(const PackedModel& model, std::pmr::memory_resource& memory, std::pmr::memory_resource& heap);

  std::size_t count() const { return source.size(); }
  VertexRange surface() const { return {0, surface_vertices}; }
  VertexRange all() const { return {0, vertices}; }

  std::uint32_t vertices, surface_vertices;          // those behind the surface carry numbers
  std::pmr::vector<VertexRange> source;              // by mesh: its vertices in the source's order
  CsrTable<VertexRange> baked;                       // by mesh: in baked order, where they may lie in several ranges
  std::pmr::vector<std::uint32_t> row_block_meshes;  // by row block; count(): of numbers
};

}  // namespace fb::runtime
