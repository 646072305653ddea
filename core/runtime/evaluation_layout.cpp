#include "runtime/evaluation_layout.h"

#include <algorithm>

#include "base/checked.h"
#include "runtime/float_mode.h"

namespace fb::runtime {
namespace {

std::pmr::vector<std::uint32_t> inverse(const std::vector<std::uint32_t>& order, std::pmr::memory_resource& memory) {
  std::pmr::vector<std::uint32_t> indices(order.size(), &memory);
  for (std::uint32_t i = 0; i < order.size(); ++i) indices[order[i]] = i;
  return indices;
}

// The first row of every row block, then the number of rows.
std::pmr::vector<std::uint32_t> block_rows(const PackedModel& model, std::pmr::memory_resource& heap) {
  std::pmr::vector<std::uint32_t> rows(&heap);
  rows.reserve(model.row_blocks.size() + 1);
  for (const PackedRowBlock& block : model.row_blocks) rows.push_back(block.first_row);
  rows.push_back(checked_u32(model.rest.points.size(), "the rows of the basis"));
  return rows;
}

// Large pages if the digits of layers and basis, about one byte a value, fill one.
std::pmr::memory_resource& memory_for(const PackedModel& model, const EvaluationMemory& from, LargePages& pages) {
  if (from.blocks) return *from.blocks;
  std::size_t bytes = 0;
  for (const PackedRegion& region : model.regions)
    for (const PackedLayer& layer : region.layers) bytes += layer.weights.size();
  for (const PackedRowBlock& block : model.row_blocks) bytes += block.values.size();
  return bytes < LargePages::page ? *from.heap : pages;
}

}  // namespace

EvaluationLayout::EvaluationLayout(const PackedModel& model, const EvaluationMemory& from,
                                   const PoseKernels& pose_kernels)
    : schema(model.schema),
      kernels(pose_kernels),
      pages(*from.heap),
      memory(memory_for(model, from, pages)),
      features(model, memory, *from.heap),
      networks(&memory),
      gate_slopes(&memory),
      row_blocks(&memory),
      direct(&memory),
      coefficient_offsets(&memory),
      list_offsets(&memory),
      scatter(memory),
      row_block_regions(memory),
      rest_positions(model.rest.points.begin(), model.rest.points.end(), &memory),
      rest_rows(model.rest.points.size() + padding, &memory),
      order(model.order.begin(), model.order.end(), &memory),
      baked_index(inverse(model.order, memory)),
      meshes(model, memory, *from.heap),
      details(memory),
      skin(model, baked_index, memory, *from.heap),
      sockets(model, baked_index, memory),
      errors(model, baked_index, memory),
      exact(model, memory),
      normals(model.rest, baked_index, block_rows(model, *from.heap), memory, *from.heap),
      tangents(model.rest, baked_index, memory, *from.heap),
      coefficient_count(model.columns) {
  for (std::uint32_t row = 0; row < rest_positions.size(); ++row)
    rest_rows[row] = rest_positions[model.coordinate(row)];
  direct.reserve(model.direct.size());
  for (const std::uint32_t feature : model.direct) direct.push_back(features.graph_index(feature));
  with_float_mode([&] {
    add_networks(model, *from.heap);
    add_row_blocks(model);
  });
  find_list_offsets(model);
  find_scatter_table(model, *from.heap);
  find_row_block_regions(*from.heap);
  with_float_mode([&] { details.add_levels(model, baked_index, coefficient_offsets, row_blocks, memory, *from.heap); });
}

void EvaluationLayout::add_networks(const PackedModel& model, std::pmr::memory_resource& heap) {
  networks.reserve(model.regions.size());
  std::size_t coefficient = direct.size();
  for (const PackedRegion& region : model.regions) {
    RegionNetwork& network = networks.emplace_back(kernels, region, memory);
    network.find_rest(kernels, region.name.c_str(), heap);
    region_names.push_back(region.name);
    gate_slopes.push_back(region.gate.features.empty() ? 0 : region.gate.slope);
    coefficient_offsets.push_back(static_cast<std::uint32_t>(coefficient));
    coefficient += network.output_count();
    max_width = std::max(max_width, network.max_width());
    max_work_size = std::max(max_work_size, network.work_size());
  }
  coefficient_offsets.push_back(static_cast<std::uint32_t>(coefficient));
}

void EvaluationLayout::add_row_blocks(const PackedModel& model) {
  row_blocks.reserve(model.row_blocks.size());
  for (const PackedRowBlock& block : model.row_blocks) {
    row_blocks.emplace_back(kernels, block, memory);
    max_block_rows = std::max<std::size_t>(max_block_rows, block.row_count);
    blocks_of_vertices = blocks_of_vertices && block.first_row % 3 == 0;
  }
}

void EvaluationLayout::find_list_offsets(const PackedModel& model) {
  std::size_t entries = 0;
  const auto add = [&](std::size_t longest) {
    list_offsets.push_back(checked_u32(entries, "the inputs of all matrices"));
    entries += longest + padding;
  };
  for (const RegionNetwork& network : networks) add(network.input_count());
  for (const PackedRegion& region : model.regions) add(region.gate.features.size());
  for (const RowBlockMatrix& block : row_blocks) add(block.input_count());
  list_offsets.push_back(checked_u32(entries, "the inputs of all matrices"));
  for (std::size_t first = 0; first < row_blocks.size(); first += row_blocks_per_pass)
    max_pass_entries =
        std::max(max_pass_entries, row_block_entries(first, std::min(first + row_blocks_per_pass, row_blocks.size())));
}

void EvaluationLayout::find_scatter_table(const PackedModel& model, std::pmr::memory_resource& heap) {
  CsrBuilder<ScatterEntry> entries(model.features.size(), 0, heap);
  for (std::uint32_t r = 0; r < model.regions.size(); ++r) {
    const PackedRegion& region = model.regions[r];
    for (std::uint32_t i = 0; i < region.features.size(); ++i)
      entries.add(features.graph_index(region.features[i]), {r, networks[r].input_offset(i), 1});
    for (const std::uint32_t feature : region.gate.features)
      entries.add(features.graph_index(feature), {static_cast<std::uint32_t>(gate_list(r)), 0, 1});
  }
  for (std::uint32_t b = 0; b < row_blocks.size(); ++b) {
    const RowBlockMatrix& block = row_blocks[b];
    for (std::uint32_t i = 0; i < block.input_count(); ++i)
      if (block.column(i) < direct.size())
        entries.add(direct[block.column(i)],
                    {static_cast<std::uint32_t>(row_block_list(b)), block.offset(i), block.scale(i)});
  }
  entries.build(scatter);
}

void EvaluationLayout::find_row_block_regions(std::pmr::memory_resource& heap) {
  CsrBuilder<RegionInputs> regions(row_blocks.size(), 0, heap);
  for (std::uint32_t b = 0; b < row_blocks.size(); ++b)
    for (std::uint32_t r = 0; r < networks.size(); ++r) {
      const auto [low, high] = row_blocks[b].inputs_of(coefficient_offsets[r], coefficient_offsets[r + 1]);
      for (const RowBlockMatrix::InputRange range : {low, high})
        if (range.begin < range.end) regions.add(b, {r, range.begin, range.end});
    }
  regions.build(row_block_regions);
}

}  // namespace fb::runtime
