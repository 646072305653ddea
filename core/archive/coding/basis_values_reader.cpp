#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <span>

#include "archive/coding/coding_reader.h"
#include "archive/coding/coding_symbols.h"
#include "archive/coding/rans_reader.h"

namespace fb::archive {
namespace {

// The residuals of class symbols below small_unit_symbols.
std::array<AxisVector, small_unit_symbols> small_unit_residuals() {
  std::array<AxisVector, small_unit_symbols> residuals;
  for (std::uint32_t s = 0; s < small_unit_symbols; ++s)
    residuals[s] = AxisVector{small_residuals[s % 3], small_residuals[s / 3 % 3], small_residuals[s / 9], 0};
  return residuals;
}

// Decodes the residuals of units, four at a time, one a stream, so that the processor overlaps their latencies.
class ResidualDecoder {
 public:
  ResidualDecoder(const FrequencyTables& tables, const RansStreams& streams) : tables_(tables), streams_(streams) {}

  const RansStreams& streams() const { return streams_; }
  // False after symbols that no valid archive holds. Decoding may continue: it stays within memory.
  bool valid() const {
    return class_valid_ && std::none_of(streams_.begin(), streams_.end(), [](const auto& s) { return s.exhausted(); });
  }

  // Stops early if a stream is exhausted.
  void decode(std::span<const CodingUnit> units, std::size_t class_table, AxisVector* residuals) {
    while (!units.empty() && valid()) {
      const std::size_t count = std::min(units.size(), units_per_check);
      // Local, so that the states stay in registers.
      RansStream first = streams_[0], second = streams_[1], third = streams_[2], fourth = streams_[3];
      std::size_t i = 0;
      for (; i + stream_count <= count; i += stream_count, residuals += stream_count) {
        residuals[0] = decode_unit(first, units[i], class_table);
        residuals[1] = decode_unit(second, units[i + 1], class_table);
        residuals[2] = decode_unit(third, units[i + 2], class_table);
        residuals[3] = decode_unit(fourth, units[i + 3], class_table);
      }
      streams_ = {first, second, third, fourth};
      for (; i < count; ++i) {
        *residuals++ = decode_unit(streams_[0], units[i], class_table);
        std::rotate(streams_.begin(), streams_.begin() + 1, streams_.end());
        next_stream_ = (next_stream_ + 1) % stream_count;
      }
      units = units.subspan(count);
    }
  }

  // All units have been decoded: puts the streams into their order.
  void finish() {
    std::rotate(streams_.begin(), streams_.begin() + (stream_count - next_stream_) % stream_count, streams_.end());
  }

 private:
  // Units decoded between two checks for exhausted streams: a unit takes at most seven words.
  static constexpr std::size_t units_per_check = stream_count * (RansStream::padding_words / 8);

  AxisVector decode_unit(RansStream& stream, const CodingUnit& unit, std::size_t class_table) {
    const std::uint32_t symbol = stream.symbol(tables_, class_table);
    if (symbol < small_unit_symbols) return small_residuals_[symbol];
    std::uint32_t unit_class = symbol - class_symbol_base;
    if (unit_class > max_class) {
      class_valid_ = false;
      unit_class = 2;
    }
    std::int32_t residuals[3] = {};
    const int offset = (1 << unit_class) - 1;
    const std::uint32_t raw_bits = unit_class > max_coded_bits ? unit_class - max_coded_bits : 0;
    bool class_reached = false;
    for (std::uint32_t i = 0; i < unit.count; ++i) {
      const std::uint32_t table = residual_table(unit_class, i + 1 == unit.count, class_reached);
      std::uint32_t code = stream.symbol(tables_, table) << raw_bits;
      if (raw_bits > 0) code |= stream.bits(raw_bits);
      const int residual = static_cast<int>(code) - offset;
      residuals[unit.axis + i] = residual;
      class_reached = class_reached || std::abs(residual) > offset / 2;
    }
    return AxisVector{residuals[0], residuals[1], residuals[2], 0};
  }

  const std::array<AxisVector, small_unit_symbols> small_residuals_ = small_unit_residuals();
  const FrequencyTables& tables_;
  RansStreams streams_;  // the one of the next unit first
  std::size_t next_stream_ = 0;
  bool class_valid_ = true;
};

// All bits set on the axes of the unit.
AxisVector axis_mask(const CodingUnit& unit) {
  AxisVector mask{};
  for (std::uint32_t i = 0; i < unit.count; ++i) mask[unit.axis + i] = -1;
  return mask;
}

// Adds residuals to predictions.
class ValueRestorer {
 public:
  ValueRestorer(std::uint32_t vertices, std::pmr::memory_resource& memory) : history_(vertices, memory) {}

  // False after a value out of range.
  bool valid() const { return !(out_of_range_[0] | out_of_range_[1] | out_of_range_[2]); }

  // `values`: of the segment, one a row.
  void restore(std::span<const CodingUnit> units, const AxisVector* residuals, bool wide, std::int16_t* values) {
    const AxisVector largest = AxisVector{} + (wide ? largest_wide : largest_narrow);
    for (const CodingUnit& unit : units) {
      AxisVector value = history_.predicted(unit) + *residuals;
      if (unit.count == 3) {
        out_of_range_ |= magnitudes(value) > largest;
        store(value, values + unit.row);
      } else {
        const AxisVector present = axis_mask(unit);
        out_of_range_ |= (present & (magnitudes(value) > largest)) | (~present & *residuals);
        for (std::uint32_t i = 0; i < unit.count; ++i)
          values[unit.row + i] = static_cast<std::int16_t>(value[unit.axis + i]);
        value = (present & value) | (~present & history_.values(unit.rank));
      }
      history_.set(unit.rank, value << 16 >> 16);  // bounds invalid values until valid() is checked
      ++residuals;
    }
  }
  // A column is complete: clears the vertices of these units.
  void clear(std::span<const CodingUnit> units) { history_.clear(units); }

 private:
  static void store(AxisVector value, std::int16_t* values) {
    for (std::size_t axis = 0; axis < 3; ++axis) values[axis] = static_cast<std::int16_t>(value[axis]);
  }

  ColumnHistory history_;
  AxisVector out_of_range_{};  // not 0 on an axis after a value out of range
};

// Allocates the values of the row blocks, all 0.
void allocate_values(ByteReader& in, PackedModel& model) {
  for (PackedRowBlock& block : model.row_blocks) {
    const std::size_t count = checked_multiply(block.columns.size(), block.row_count, in.where().c_str());
    in.budget().resize(block.values, count, "basis values");
  }
}

// The coding units with their predictors, whose symbols are in turn in the streams of the first part.
CodingUnits read_units(const RansReader& rans, RansStreams& streams, std::uint32_t vertices, const PackedModel& model,
                       std::pmr::memory_resource& memory) {
  std::size_t coded = 0;
  return coding_units(
      model.rest, vertices, model.order, model.row_blocks,
      [&](CodingUnit& unit, std::span<const Predictor> candidates) {
        const auto count = static_cast<std::uint32_t>(candidates.size());
        RansStream& stream = streams[coded % stream_count];
        if (count > 1) ++coded;
        const std::uint32_t pair = count > 1 ? stream.symbol(rans.tables(), pair_table) : 0;
        if (pair >= pair_index(0, count) || stream.exhausted())
          rans.corrupt(stream, "a vertex has a predictor that does not exist");
        set_predictors(unit, candidates, pair);
      },
      memory);
}

// What a worker decodes a part in, one part after the other.
struct PartWorkspace {
  PartWorkspace(const CodingUnits& units, std::uint32_t vertices, std::pmr::memory_resource& memory)
      : residuals(&memory), restorer(vertices, memory) {
    std::size_t most_units = 0;
    for (const auto& of_block : units) most_units = std::max(most_units, of_block.size());
    residuals.resize(most_units);
  }
  std::pmr::vector<AxisVector> residuals;  // of the units of a segment
  ValueRestorer restorer;
};

// Decodes the columns of a part. `tables`: the class table of each of their segments.
void read_part(const RansReader& rans, const RansStreams& streams, const CodingUnits& units,
               std::span<const std::pmr::vector<ColumnSegment>> columns, std::span<const std::uint8_t> tables,
               PackedModel& model, PartWorkspace& workspace) {
  ResidualDecoder decoder(rans.tables(), streams);
  auto& [residuals, restorer] = workspace;
  auto table = tables.begin();
  for (const auto& column : columns) {
    for (const auto& [b, index] : column) {
      PackedRowBlock& block = model.row_blocks[b];
      decoder.decode(units[b], first_class_table + *table++, residuals.data());
      restorer.restore(units[b], residuals.data(), block.columns[index].wide,
                       block.values.data() + std::size_t(index) * block.row_count);
      if (!decoder.valid()) rans.corrupt(decoder.streams(), "a unit has a class that does not exist");
    }
    if (!restorer.valid()) rans.corrupt(decoder.streams(), "the basis holds a value beyond its range");
    for (const ColumnSegment& segment : column) restorer.clear(units[segment.block]);
  }
  decoder.finish();
  rans.end(decoder.streams());
}

}  // namespace

void read_basis_values(ByteReader& in, std::uint32_t vertices, const SegmentTables& tables, const Parallel& parallel,
                       PackedModel& model) {
  allocate_values(in, model);
  const RansReader rans(in, {first_class_table, first_class_table + max_class_tables}, basis_parts);
  for (const std::uint8_t table : tables)
    if (first_class_table + table >= rans.table_count()) in.corrupt("a segment has a table that does not exist");
  RansStreams streams = rans.streams(0);
  const auto units = read_units(rans, streams, vertices, model, in.budget());
  const auto segments = column_segments(model, in.budget());
  const auto first_columns = first_columns_of_parts(model, segments, in.budget());
  std::array<std::size_t, basis_parts> first_segments{};
  for (std::size_t part = 0; part + 1 < basis_parts; ++part) {
    first_segments[part + 1] = first_segments[part];
    for (std::size_t c = first_columns[part]; c < first_columns[part + 1]; ++c)
      first_segments[part + 1] += segments[c].size();
  }
  Parallel limited = parallel;
  limited.threads = static_cast<int>(std::min(worker_count(parallel), basis_parts));
  std::vector<PartWorkspace> workspaces;  // one a worker
  for (int worker = 0; worker < limited.threads; ++worker) workspaces.emplace_back(units, vertices, in.budget());
  std::array<std::atomic<bool>, basis_parts> awaited;
  for (auto& part : awaited) part = true;
  parallel_for(limited, basis_parts, [&](std::size_t part, std::size_t worker) {
    if (part >= basis_parts || worker >= workspaces.size() || !awaited[part].exchange(false))
      fail(Status::invalid_argument, "the host's parallel_for gave task %zu of %zu to worker %zu of %zu, or twice",
           part, basis_parts, worker, workspaces.size());
    const std::size_t count = first_columns[part + 1] - first_columns[part];
    read_part(rans, part == 0 ? streams : rans.streams(part), units,
              std::span(segments).subspan(first_columns[part], count), std::span(tables).subspan(first_segments[part]),
              model, workspaces[worker]);
  });
  for (const auto& part : awaited)
    if (part) fail(Status::invalid_argument, "the host's parallel_for did not run all of %zu tasks", basis_parts);
}

}  // namespace fb::archive
