#include "runtime/mesh_layout.h"

#include <algorithm>

#include "base/checked.h"

namespace fb::runtime {

MeshLayout::MeshLayout(const PackedModel& model, std::pmr::memory_resource& memory, std::pmr::memory_resource& heap)
    : vertices(checked_u32(model.rest.vertex_count(), "vertices")),
      surface_vertices(checked_u32(model.rest.surface_vertex_count(), "vertices")),
      source(&memory),
      baked(memory),
      row_block_meshes(&memory) {
  const std::vector<std::uint32_t> ends = model.rest.part_ends();
  std::pmr::vector<std::uint32_t> mesh_of(model.rest.vertex_count(), &heap);
  source.reserve(ends.size());
  for (std::uint32_t first = 0; const std::uint32_t end : ends) {
    std::fill(mesh_of.begin() + first, mesh_of.begin() + end, static_cast<std::uint32_t>(source.size()));
    source.push_back({first, end});
    first = end;
  }
  if (model.rest.carrier_vertices > 0) source.pop_back();
  const auto mesh_at = [&](std::uint32_t v) { return mesh_of[model.order.empty() ? v : model.order[v]]; };
  CsrBuilder<VertexRange> ranges(source.size(), source.size(), heap);
  for (std::uint32_t begin = 0, end; begin < surface_vertices; begin = end) {
    for (end = begin + 1; end < surface_vertices && mesh_at(end) == mesh_at(begin);) ++end;
    ranges.add(mesh_at(begin), {begin, end});
  }
  ranges.build(baked);
  row_block_meshes.reserve(model.row_blocks.size());
  for (const PackedRowBlock& block : model.row_blocks) row_block_meshes.push_back(mesh_at(block.first_row / 3));
}

}  // namespace fb::runtime
