#include "runtime/detail_layout.h"

#include <algorithm>

namespace fb::runtime {
namespace {

// The mesh of a level with its vertices in baked order.
Mesh level_mesh(const PackedModel& model, const DetailLevel& level) {
  Mesh mesh;
  for (std::uint32_t row = 0; row < 3 * level.vertices; ++row)
    mesh.points.push_back(model.rest.points[model.coordinate(row)]);
  std::vector<std::uint32_t> baked_index(model.rest.vertex_count());
  for (std::uint32_t i = 0; i < baked_index.size(); ++i) baked_index[model.order.empty() ? i : model.order[i]] = i;
  mesh.polygon_sizes = level.polygon_sizes;
  for (const std::uint32_t v : level.polygon_corners) mesh.polygon_corners.push_back(baked_index[v]);
  if (!level.uv_corners.empty()) mesh.uvs = model.rest.uvs;
  mesh.uv_corners = level.uv_corners;
  return mesh;
}

std::uint32_t blocks_of(const PackedModel& model, const DetailLevel& level) {
  const auto end = std::partition_point(
      model.row_blocks.begin(), model.row_blocks.end(),
      [&](const PackedRowBlock& block) { return std::size_t(block.first_row) < 3 * std::size_t(level.vertices); });
  return static_cast<std::uint32_t>(end - model.row_blocks.begin());
}

// The first row of each row block of a level, then its number of rows.
std::pmr::vector<std::uint32_t> level_block_rows(const PackedModel& model, const DetailLevel& level,
                                                 std::pmr::memory_resource& heap) {
  std::pmr::vector<std::uint32_t> rows(&heap);
  for (std::uint32_t b = 0; b < blocks_of(model, level); ++b) rows.push_back(model.row_blocks[b].first_row);
  rows.push_back(3 * level.vertices);
  return rows;
}

// Charges what a level's mesh and triangles take to the memory of temporaries, which their vectors do not come from.
std::pmr::vector<std::uint32_t> charged_numbers(const PackedModel& model, const DetailLevel& level,
                                                std::pmr::memory_resource& heap) {
  std::pmr::vector<std::uint32_t> numbers(&heap);
  numbers.reserve(2 * 3 * std::size_t(level.vertices) + model.rest.vertex_count() + level.polygon_sizes.size() +
                  2 * 3 * level.polygon_corners.size() + level.uv_corners.size() + model.rest.uvs.size());
  return numbers;
}

}  // namespace

DetailLevelLayout::DetailLevelLayout(const PackedModel& model, const DetailLevel& level, const Mesh& surface,
                                     std::span<const std::uint32_t> block_rows,
                                     std::span<const std::uint32_t> coefficient_offsets,
                                     const std::pmr::vector<RowBlockMatrix>& matrices,
                                     std::pmr::memory_resource& memory, std::pmr::memory_resource& heap)
    : vertices(level.vertices),
      blocks(static_cast<std::uint32_t>(block_rows.size() - 1)),
      used(model.columns, 1, &memory),
      block_regions(memory),
      outputs(coefficient_offsets.size() - 1, &memory),
      all_outputs(coefficient_offsets.size() - 1, &memory),
      normals(surface, {}, block_rows, memory, heap),
      tangents(surface, {}, memory, heap) {
  const std::vector<std::uint8_t>& kept = level.used_coefficients;
  std::copy(kept.begin(), kept.end(), used.begin() + std::ptrdiff_t(model.direct.size()));
  CsrBuilder<RegionInputs> inputs(matrices.size(), 0, heap);
  for (std::uint32_t b = 0; b < matrices.size(); ++b) {
    const bool of_level = b < blocks, of_carriers = matrices[b].first_row() >= 3 * model.rest.surface_vertex_count();
    if (!of_level && !of_carriers) continue;
    for (std::uint32_t r = 0; r < outputs.size(); ++r) {
      const auto [low, high] = matrices[b].inputs_of(coefficient_offsets[r], coefficient_offsets[r + 1]);
      for (const RowBlockMatrix::InputRange range : {low, high})
        for (std::uint32_t i = range.begin; i < range.end; ++i) {
          if (!uses(matrices[b].column(i))) continue;
          const std::uint32_t first = i;
          while (i + 1 < range.end && uses(matrices[b].column(i + 1))) ++i;
          inputs.add(b, {r, first, i + 1});
          const std::uint32_t last = matrices[b].column(i) - coefficient_offsets[r] + 1;
          if (of_level) outputs[r] = std::max(outputs[r], last);
          all_outputs[r] = std::max(all_outputs[r], last);
        }
    }
  }
  inputs.build(block_regions);
}

void DetailLayout::add_levels(const PackedModel& model, std::span<const std::uint32_t> baked_index,
                              std::span<const std::uint32_t> coefficient_offsets,
                              const std::pmr::vector<RowBlockMatrix>& matrices, std::pmr::memory_resource& memory,
                              std::pmr::memory_resource& heap) {
  if (model.levels.empty()) return;
  levels.reserve(model.levels.size());
  for (const DetailLevel& level : model.levels) {
    const auto charge = charged_numbers(model, level, heap);
    levels.emplace_back(model, level, level_mesh(model, level), level_block_rows(model, level, heap),
                        coefficient_offsets, matrices, memory, heap);
  }
  points.reserve(model.rest.surface_vertex_count() - levels.back().vertices);
  for (std::size_t k = model.levels.size(); k > 0; --k) {
    const auto charge = charged_numbers(model, model.levels[k - 1], heap);
    const std::vector<std::uint32_t> triangles = model.levels[k - 1].triangles();
    for (const SurfacePoint& from : model.levels[k - 1].points) {
      DetailPoint& point = points.emplace_back();
      const int codes[3] = {256 - from.weights[0] - from.weights[1], from.weights[0], from.weights[1]};
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t v = triangles[3 * std::size_t(from.triangle) + c];
        point.corners[c] = baked_index.empty() ? v : baked_index[v];
        point.weights[c] = static_cast<float>(codes[c]) / 256;
      }
    }
  }
}

DetailChoice::DetailChoice(const DetailLayout& layout, float lod) {
  const std::size_t last = layout.levels.size();
  number = lod >= static_cast<float>(last) ? last : static_cast<std::size_t>(lod);
  share = number == last ? 0 : lod - static_cast<float>(number);
  if (number > 0) level = &layout.levels[number - 1];
  if (share > 0) next = &layout.levels[number];
}

void slide_vertices(const DetailLayout& layout, const DetailChoice& choice, std::uint32_t first, std::uint32_t end,
                    bool all, float* rows) {
  const auto last_level = layout.levels.empty() ? UINT32_MAX : layout.levels.back().vertices;
  const auto surface = static_cast<std::uint32_t>(last_level + layout.points.size());
  const std::uint32_t of_level = choice.level ? choice.level->vertices : surface;
  const std::uint32_t sliding = choice.next ? choice.next->vertices : of_level;
  end = std::min(end, all ? surface : of_level);
  for (std::uint32_t i = std::max(first, sliding); i < end; ++i) {
    const DetailPoint& point = layout.points[i - last_level];
    const float *const a = rows + 3 * std::size_t(point.corners[0]),
                       *const b = rows + 3 * std::size_t(point.corners[1]),
                       *const c = rows + 3 * std::size_t(point.corners[2]);
    float* const to = rows + 3 * std::size_t(i);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float target = (point.weights[0] * a[axis] + point.weights[1] * b[axis]) + point.weights[2] * c[axis];
      to[axis] = i < of_level ? to[axis] + choice.share * (target - to[axis]) : target;
    }
  }
}

}  // namespace fb::runtime
