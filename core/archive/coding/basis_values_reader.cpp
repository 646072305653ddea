#include <algorithm>
#include <array>
#include <cstdlib>
#include <span>
#include <type_traits>

#include "archive/coding/coding_reader.h"
#include "archive/coding/contexts.h"
#include "archive/coding/rans_reader.h"

namespace fb::archive {
namespace {

// Lookup tables for class symbols: the frequency table of each condition, and the residuals of classes 0 and 1.
struct ClassSymbolTables {
  explicit ClassSymbolTables(const FrequencyTables& tables) {
    for (std::uint32_t c = 0; c < condition_count; ++c)
      table_of_condition[c] = tables.table_of_context[class_context(c)];
    for (std::uint32_t s = 0; s < small_unit_symbols; ++s)
      residuals[s] = AxisVector{small_residuals[s % 3], small_residuals[s / 3 % 3], small_residuals[s / 9], 0};
  }
  std::array<std::uint8_t, condition_count> table_of_condition;
  std::array<AxisVector, small_unit_symbols> residuals;
};

// Decodes the columns of one stream, unit by unit.
class StreamDecoder {
 public:
  // `columns`: those of the stream. All references must outlive the decoder; values go to `model`.
  StreamDecoder(PackedModel& model, std::uint32_t vertices, const FrequencyTables& tables,
                const ClassSymbolTables& class_tables, const CodingUnits& units,
                std::span<const std::pmr::vector<ColumnSegment>> columns, const RansStream& stream,
                std::pmr::memory_resource& memory)
      : stream_(stream),
        tables_(tables),
        class_tables_(class_tables),
        history_(vertices, memory),
        model_(model),
        units_(units),
        columns_(columns) {
    next_segment();
  }

  const RansStream& stream() const { return stream_; }
  // Units left in the current segment; 0 only at the end of the stream.
  std::size_t units_left() const { return static_cast<std::size_t>(end_ - unit_); }
  // False after symbols that no valid archive holds. Decoding may continue: it stays within memory.
  bool valid() const {
    return class_valid_ && !stream_.exhausted() && !(out_of_range_[0] | out_of_range_[1] | out_of_range_[2]);
  }

  void decode_unit() {
    const CodingUnit& unit = *unit_++;
    const std::uint32_t symbol =
        stream_.symbol_of_table(tables_, class_tables_.table_of_condition[history_.condition(unit)]);
    AxisVector residuals;
    std::uint32_t unit_class = symbol > 0;
    if (symbol < small_unit_symbols) {
      residuals = class_tables_.residuals[symbol];
    } else {
      unit_class = symbol - class_symbol_base;
      residuals = unit.count == 3
                      ? decode_residuals(unit, std::integral_constant<std::uint32_t, 0>(),
                                         std::integral_constant<std::uint32_t, 3>(), unit_class)
                      : decode_residuals(unit, std::uint32_t(unit.axis), std::uint32_t(unit.count), unit_class);
    }
    AxisVector values = history_.predicted(unit) + residuals;
    const AxisVector present = unit.count == 3 ? AxisVector{-1, -1, -1, -1} : axis_mask(unit);
    out_of_range_ |= (present & (magnitudes(values) > history_.max_magnitude())) | (~present & residuals);
    values = values << 16 >> 16;  // bounds invalid values until valid() is checked
    if (unit.count < 3) values = (present & values) | (~present & history_.values(unit.rank));
    if (unit.count == 3)
      for (std::size_t axis = 0; axis < 3; ++axis) values_[unit.row + axis] = static_cast<std::int16_t>(values[axis]);
    else
      for (std::uint32_t i = 0; i < unit.count; ++i)
        values_[unit.row + i] = static_cast<std::int16_t>(values[unit.axis + i]);
    history_.set(unit.rank, values, residuals, unit_class);
  }

  // Goes on to the next segment if no units are left in this one.
  void next_segment() {
    if (units_left() > 0) return;
    while (column_ < columns_.size() && segment_ == columns_[column_].size()) {
      for (const ColumnSegment& segment : columns_[column_]) history_.clear(units_[segment.block]);
      ++column_;
      segment_ = 0;
    }
    if (column_ == columns_.size()) return;
    const auto [b, index] = columns_[column_][segment_++];
    PackedRowBlock& block = model_.row_blocks[b];
    values_ = block.values.data() + std::size_t(index) * block.row_count;
    history_.begin_segment(block.columns[index].wide);
    unit_ = units_[b].data();
    end_ = unit_ + units_[b].size();
  }

 private:
  // The residuals of a unit of class 2 or more. Axis and count are integral constants in the common case of three rows,
  // so that the loop unrolls.
  template <class Axis, class Count>
  AxisVector decode_residuals(const CodingUnit& unit, Axis first_axis, Count count, std::uint32_t& unit_class) {
    if (unit_class > max_class) {
      class_valid_ = false;
      unit_class = 2;
    }
    std::int32_t residuals[3] = {};
    const int offset = (1 << unit_class) - 1;
    const std::uint32_t raw_bits = unit_class > max_coded_bits ? unit_class - max_coded_bits : 0;
    bool class_reached = false;
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t activity = history_.activity(unit, first_axis + i);
      std::uint32_t code =
          stream_.symbol(tables_, residual_context(unit_class, activity, i + 1 == count, class_reached)) << raw_bits;
      if (raw_bits > 0) code |= stream_.bits(raw_bits);
      residuals[first_axis + i] = static_cast<int>(code) - offset;
      class_reached = class_reached || std::abs(residuals[first_axis + i]) > offset / 2;
    }
    return AxisVector{residuals[0], residuals[1], residuals[2], 0};
  }

  // All bits set on the axes of the unit.
  static AxisVector axis_mask(const CodingUnit& unit) {
    AxisVector mask{};
    for (std::uint32_t i = 0; i < unit.count; ++i) mask[unit.axis + i] = -1;
    return mask;
  }

  RansStream stream_;
  const CodingUnit *unit_ = nullptr, *end_ = nullptr;
  std::int16_t* values_ = nullptr;  // of the current segment
  bool class_valid_ = true;
  AxisVector out_of_range_{};  // not 0 after a value out of range
  const FrequencyTables& tables_;
  const ClassSymbolTables& class_tables_;
  ColumnHistory history_;
  PackedModel& model_;
  const CodingUnits& units_;
  std::span<const std::pmr::vector<ColumnSegment>> columns_;
  std::size_t column_ = 0, segment_ = 0;  // the next segment
};

// Units decoded between two checks for exhausted streams: a unit takes at most seven words.
constexpr std::size_t units_per_check = RansStream::padding_words / 8;

// Decodes all streams in turns of one unit, so that the processor overlaps their latencies. Stops early if a stream
// becomes invalid.
void decode_streams(std::vector<StreamDecoder>& streams) {
  std::vector<StreamDecoder*> active;
  for (StreamDecoder& stream : streams) active.push_back(&stream);
  for (;;) {
    std::erase_if(active, [](const StreamDecoder* stream) { return stream->units_left() == 0; });
    if (active.empty() || !std::all_of(active.begin(), active.end(), [](auto* stream) { return stream->valid(); }))
      return;
    std::size_t units = units_per_check;
    for (const StreamDecoder* stream : active) units = std::min(units, stream->units_left());
    for (; units > 0; --units)
      for (StreamDecoder* const stream : active) stream->decode_unit();
    for (StreamDecoder* const stream : active) stream->next_segment();
  }
}

// Allocates the values of the row blocks, all 0.
void allocate_values(ByteReader& in, PackedModel& model) {
  for (PackedRowBlock& block : model.row_blocks) {
    const std::size_t count = checked_multiply(block.columns.size(), block.row_count, in.where().c_str());
    in.budget().resize(block.values, count, "basis values");
  }
}

// The coding units with their predictors, which `stream` codes.
CodingUnits read_units(const RansReader& rans, RansStream& stream, std::uint32_t vertices, const PackedModel& model,
                       std::pmr::memory_resource& memory) {
  return coding_units(
      model.rest, vertices, model.order, model.row_blocks,
      [&](CodingUnit& unit, std::span<const Predictor> candidates) {
        const auto count = static_cast<std::uint32_t>(candidates.size());
        const std::uint32_t pair = count > 1 ? stream.symbol(rans.tables(), pair_context(unit)) : 0;
        if (pair >= pair_index(0, count) || stream.exhausted())
          rans.corrupt(stream, "a vertex has a predictor that does not exist");
        set_predictors(unit, candidates, pair);
      },
      memory);
}

}  // namespace

void read_basis_values(ByteReader& in, std::uint32_t vertices, PackedModel& model) {
  allocate_values(in, model);
  const RansReader rans(in, basis_contexts);
  RansStreams streams = rans.streams();
  const auto units = read_units(rans, streams[0], vertices, model, in.budget());
  const auto segments = column_segments(model, in.budget());
  const auto first_columns = first_columns_of_streams(model, segments, in.budget());
  const ClassSymbolTables class_tables(rans.tables());
  std::vector<StreamDecoder> decoders;
  decoders.reserve(stream_count);
  for (std::size_t s = 0; s < stream_count; ++s) {
    const auto columns = std::span(segments).subspan(first_columns[s], first_columns[s + 1] - first_columns[s]);
    decoders.emplace_back(model, vertices, rans.tables(), class_tables, units, columns, streams[s], in.budget());
  }
  decode_streams(decoders);
  for (std::size_t s = 0; s < stream_count; ++s) {
    if (!decoders[s].valid()) rans.corrupt(decoders[s].stream(), "the basis holds a value beyond its range");
    streams[s] = decoders[s].stream();
  }
  rans.end(streams);
}

}  // namespace fb::archive
