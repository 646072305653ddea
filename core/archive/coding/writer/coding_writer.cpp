#include "archive/coding/writer/coding_writer.h"

#include <bit>

#include "archive/coding/coding_reader.h"
#include "archive/coding/writer/choose_predictors.h"
#include "archive/coding/writer/rans_writer.h"
#include "archive/coding/writer/unit_symbols.h"

namespace fb::archive {
namespace {

std::vector<std::uint32_t> zigzag_deltas(const std::vector<std::uint32_t>& values) {
  std::vector<std::uint32_t> deltas;
  std::uint32_t before = 0;
  for (const std::uint32_t value : values) {
    deltas.push_back(to_zigzag(value - before));
    before = value;
  }
  return deltas;
}

bool same_bits(float a, float b) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

// The columns of the row blocks, column by column.
void write_segments(ByteWriter& out, const PackedModel& model) {
  std::vector<std::uint32_t> counts, deltas;
  std::vector<std::uint8_t> flags;
  std::vector<float> scales;
  for (const auto& segments : column_segments(model)) {
    counts.push_back(checked_u32(segments.size(), "segments"));
    std::uint32_t before = 0;
    for (const auto& [b, index] : segments) {
      const PackedColumn& column = model.row_blocks[b].columns[index];
      deltas.push_back(b - before);
      before = b;
      const bool new_scale = scales.empty() || !same_bits(scales.back(), column.scale);
      flags.push_back(static_cast<std::uint8_t>((column.wide ? segment_16_bit_flag : 0) |
                                                (new_scale ? segment_new_scale_flag : 0)));
      if (new_scale) scales.push_back(column.scale);
    }
  }
  out.planes(counts);
  out.planes(deltas);
  out.numbers(flags);
  out.count(scales.size(), "scales");
  out.float_planes(scales);
}

void write_segment(RansWriter& out, ColumnHistory& history, std::span<const CodingUnit> units, bool wide,
                   const std::int16_t* values) {
  history.begin_segment(wide);
  for (const CodingUnit& unit : units) {
    const AxisVector of_vertex = values_of_vertex(history, unit, values + unit.row);
    const AxisVector residuals = residuals_of(history, unit, of_vertex);
    write_unit(out, history, unit, residuals);
    history.set(unit.rank, of_vertex, residuals, class_of(residuals));
  }
}

}  // namespace

ByteWriter write_weights(const PackedModel& model) {
  RansWriter rans(weight_contexts);
  for (const PackedRegion& region : model.regions)
    for (std::size_t l = 0; l < region.layers.size(); ++l) {
      const PackedLayer& layer = region.layers[l];
      const std::uint32_t context = weight_context(l, region.layers.size());
      for (std::size_t i = 0; i < layer.weights.size(); ++i) {
        rans.select_stream(i % stream_count);
        const int weight = layer.weights[i], digit = layer.wide ? high_digit(weight) : weight;
        rans.symbol(context + (layer.wide ? high_digit_contexts : 0),
                    static_cast<std::uint32_t>(digit + largest_narrow));
        if (layer.wide) rans.symbol(context + low_digit_contexts, static_cast<std::uint32_t>(low_digit(weight) + 128));
      }
    }
  ByteWriter out;
  rans.write(out);
  return out;
}

ByteWriter write_basis(const PackedModel& model) {
  ByteWriter out;
  out.number(model.columns);
  out.number(std::uint32_t(!model.order.empty()));
  out.planes(zigzag_deltas(model.order));
  out.count(model.row_blocks.size(), "row blocks");
  std::vector<std::uint32_t> rows;
  for (const PackedRowBlock& block : model.row_blocks) rows.push_back(block.row_count);
  out.planes(rows);
  write_segments(out, model);
  return out;
}

ByteWriter write_basis_values(const PackedModel& model) {
  const auto units = choose_predictors(model);
  RansWriter rans(basis_contexts);
  for (const auto& units_of_block : units)
    for (const CodingUnit& unit : units_of_block)
      if (unit.predictor_count > 1) rans.symbol(pair_context(unit), unit.predictor_pair);
  ColumnHistory history(model.rest.vertex_count());
  const auto segments = column_segments(model);
  const auto first_columns = first_columns_of_streams(model, segments);
  for (std::size_t stream = 0; stream < stream_count; ++stream) {
    rans.select_stream(stream);
    for (std::size_t c = first_columns[stream]; c < first_columns[stream + 1]; ++c) {
      for (const auto& [b, index] : segments[c]) {
        const PackedRowBlock& block = model.row_blocks[b];
        write_segment(rans, history, units[b], block.columns[index].wide,
                      block.values.data() + std::size_t(index) * block.row_count);
      }
      for (const ColumnSegment& segment : segments[c]) history.clear(units[segment.block]);
    }
  }
  ByteWriter out;
  rans.write(out);
  return out;
}

}  // namespace fb::archive
