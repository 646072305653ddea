#include "archive/coding/writer/coding_writer.h"

#include <algorithm>
#include <bit>
#include <optional>
#include <span>

#include "archive/coding/coding_reader.h"
#include "archive/coding/writer/choose_predictors.h"
#include "archive/coding/writer/rans_writer.h"
#include "archive/coding/writer/segment_tables.h"
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

// The columns of the row blocks, column by column. `tables`: of the segments in this order.
void write_segments(ByteWriter& out, const PackedModel& model, std::span<const std::uint8_t> tables) {
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
                                                (new_scale ? segment_new_scale_flag : 0) |
                                                tables[flags.size()] << segment_table_shift));
      if (new_scale) scales.push_back(column.scale);
    }
  }
  out.planes(counts);
  out.planes(deltas);
  out.numbers(flags);
  out.count(scales.size(), "scales");
  out.float_planes(scales);
}

ByteWriter write_columns(const PackedModel& model, std::span<const std::uint8_t> tables) {
  ByteWriter out;
  out.number(model.columns);
  out.number(std::uint32_t(!model.order.empty()));
  out.planes(zigzag_deltas(model.order));
  out.count(model.row_blocks.size(), "row blocks");
  std::vector<std::uint32_t> rows;
  for (const PackedRowBlock& block : model.row_blocks) rows.push_back(block.row_count);
  out.planes(rows);
  write_segments(out, model, tables);
  return out;
}

// Codes the values of a segment: the class symbols of its units, then the residuals of those of class 2 or more; both
// in the streams of its part in turn.
class SegmentWriter {
 public:
  SegmentWriter(RansWriter& out, std::size_t part, std::uint32_t class_table)
      : out_(out), part_(part), class_table_(class_table) {}

  void unit(const CodingUnit& unit, AxisVector residuals) {
    out_.select(part_, units_++ % stream_count);
    const std::uint32_t unit_class = write_class(out_, class_table_, residuals);
    if (unit_class >= 2) large_.push_back({&unit, unit_class, residuals});
  }
  // All units have been given.
  void finish() {
    for (std::size_t i = 0; i < large_.size(); ++i) {
      out_.select(part_, i % stream_count);
      write_residuals(out_, *large_[i].unit, large_[i].unit_class, large_[i].residuals);
    }
  }

 private:
  struct LargeUnit {
    const CodingUnit* unit;
    std::uint32_t unit_class;
    AxisVector residuals;
  };

  RansWriter& out_;
  std::size_t part_, units_ = 0;
  std::uint32_t class_table_;
  std::vector<LargeUnit> large_;
};

ByteWriter write_values(const PackedModel& model, const CodingUnits& units, std::span<const std::uint8_t> tables) {
  const std::uint32_t class_tables = tables.empty() ? 0 : *std::max_element(tables.begin(), tables.end()) + 1u;
  RansWriter rans(first_class_table + class_tables, basis_parts);
  std::size_t coded = 0;
  for (const auto& units_of_block : units)
    for (const CodingUnit& unit : units_of_block)
      if (unit.predictor_count > 1) {
        rans.select(0, coded++ % stream_count);
        rans.symbol(pair_table, unit.predictor_pair);
      }
  const auto first_columns = first_columns_of_parts(model, column_segments(model));
  std::size_t part = 0, next_table = 0;
  std::optional<SegmentWriter> segment;
  const auto finish_segment = [&] {
    if (segment) segment->finish();
  };
  for_each_unit(
      model, units,
      [&](std::size_t column, const ColumnSegment&) {
        while (column >= first_columns[part + 1]) ++part;
        finish_segment();
        segment.emplace(rans, part, tables[next_table++]);
      },
      [&](ColumnHistory& history, const CodingUnit& unit, std::uint32_t b, std::size_t at) {
        const AxisVector values = values_of_vertex(history, unit, &model.row_blocks[b].values[at]);
        segment->unit(unit, residuals_of(history, unit, values));
        history.set(unit.rank, values);
      });
  finish_segment();
  ByteWriter out;
  rans.write(out);
  return out;
}

}  // namespace

ByteWriter write_weights(const PackedModel& model) {
  RansWriter rans(weight_tables);
  for (const PackedRegion& region : model.regions)
    for (std::size_t l = 0; l < region.layers.size(); ++l) {
      const PackedLayer& layer = region.layers[l];
      const std::uint32_t table = weight_table(l, region.layers.size());
      for (std::size_t i = 0; i < layer.weights.size(); ++i) {
        rans.select(0, i % stream_count);
        const int weight = layer.weights[i], digit = layer.wide ? high_digit(weight) : weight;
        rans.symbol(table + (layer.wide ? high_digit_tables : 0), static_cast<std::uint32_t>(digit + largest_narrow));
        if (layer.wide) rans.symbol(table + low_digit_tables, static_cast<std::uint32_t>(low_digit(weight) + 128));
      }
    }
  ByteWriter out;
  rans.write(out);
  return out;
}

BasisSections write_basis(const PackedModel& model) {
  const CodingUnits units = choose_predictors(model);
  const std::vector<std::uint8_t> tables = choose_segment_tables(model, units);
  return {write_columns(model, tables), write_values(model, units, tables)};
}

}  // namespace fb::archive
