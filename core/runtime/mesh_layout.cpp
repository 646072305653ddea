#include "runtime/mesh_layout.h"

#include "base/checked.h"

namespace fb::runtime {

MeshLayout::MeshLayout(const PackedModel& model, std::pmr::memory_resource& memory, std::pmr::memory_resource& heap)
    : source(&memory), baked(memory), row_block_meshes(&memory) {
  const std::uint32_t vertices = checked_u32(model.rest.vertex_count(), "vertices");
  std::pmr::vector<std::uint32_t> mesh_of(vertices, &heap);
  source.reserve(std::max<std::size_t>(model.rest.parts.size(), 1));
  if (model.rest.parts.empty()) source.push_back({0, vertices});
  std::uint32_t first = 0;
  for (const MeshPart& part : model.rest.parts) {
    std::fill_n(mesh_of.begin() + first, part.vertices, static_cast<std::uint32_t>(source.size()));
    source.push_back({first, first + part.vertices});
    first += part.vertices;
  }
  const auto mesh_at = [&](std::uint32_t v) { return mesh_of[model.order.empty() ? v : model.order[v]]; };
  CsrBuilder<VertexRange> ranges(source.size(), source.size(), heap);
  for (std::uint32_t begin = 0, end; begin < vertices; begin = end) {
    for (end = begin + 1; end < vertices && mesh_at(end) == mesh_at(begin);) ++end;
    ranges.add(mesh_at(begin), {begin, end});
  }
  ranges.build(baked);
  row_block_meshes.reserve(model.row_blocks.size());
  for (const PackedRowBlock& block : model.row_blocks) row_block_meshes.push_back(mesh_at(block.first_row / 3));
}

}  // namespace fb::runtime
