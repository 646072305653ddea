#include "runtime/workspace.h"

#include <algorithm>

#include "runtime/evaluator.h"

namespace fb::runtime {

Workspace::Workspace(const Evaluator& evaluator, std::size_t poses, std::pmr::memory_resource& memory)
    : Workspace(evaluator.layout(), poses, memory) {}

Workspace::Workspace(const EvaluationLayout& layout, std::size_t poses, std::pmr::memory_resource& memory)
    : block_(poses),
      features_(layout.features, poses, memory),
      list_values_(layout.list_offsets.back() * poses, &memory),
      list_columns_(layout.list_offsets.back(), &memory),
      list_ends_(layout.list_offsets.size() - 1, &memory),
      quantised_(layout.max_pass_entries * poses, &memory),
      active_regions_(layout.networks.size(), &memory),
      coefficients_(layout.coefficient_count * poses, &memory),
      layers_(layout.max_work_size * poses, &memory),
      rows_(layout.row_stride() * poses, &memory),
      block_rows_(layout.max_block_rows * poses + padding, &memory),
      moved_(layout.row_blocks.size() * poses, &memory),
      halves_(layout.rest_positions.size() + padding, &memory),
      layer_inputs_(layout.max_width, poses, memory),
      normals_(layout.vertex_count(), layout.row_blocks.size(), layout.max_polygons(), memory),
      errors_(layout.errors, memory),
      exact_(layout.exact, poses, memory),
      skin_(layout.skin, memory),
      detail_normals_(&memory),
      detail_tangents_(&memory) {
  const bool has_tangents = !layout.tangents.signs().empty();
  if (has_tangents) tangents_.emplace(layout.vertex_count(), layout.row_blocks.size(), layout.max_polygons(), memory);
  if (!layout.details.levels.empty()) {
    const DetailLevelLayout& next = layout.details.levels[0];
    next_normals_.emplace(next.vertices, next.blocks, layout.max_level_polygons(), memory);
    detail_normals_.resize(layout.row_stride());
    if (has_tangents) {
      next_tangents_.emplace(next.vertices, next.blocks, layout.max_level_polygons(), memory);
      detail_tangents_.resize(layout.row_stride());
    }
  }
  for (std::size_t p = 0; p < poses; ++p)
    std::copy_n(layout.rest_rows.begin(), layout.rest_positions.size(), rows_.begin() + p * layout.row_stride());
}

}  // namespace fb::runtime
