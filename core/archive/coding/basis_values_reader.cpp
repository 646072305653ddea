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

// What a class symbol says of a unit's residuals: the residuals of a small one; of others, the class on axis x.
std::array<AxisVector, 256> residuals_of_class_symbols() {
  std::array<AxisVector, 256> residuals{};
  for (std::uint32_t s = 0; s < residuals.size(); ++s)
    residuals[s] = s < small_unit_symbols
                       ? AxisVector{small_residuals[s % 3], small_residuals[s / 3 % 3], small_residuals[s / 9], 0}
                       : AxisVector{static_cast<std::int32_t>(s - class_symbol_base), 0, 0, 0};
  return residuals;
}

// Decodes the residuals of segments. Symbols that follow each other are in different streams, so that the processor
// overlaps their latencies.
class ResidualDecoder {
 public:
  // `large`: room for one unit more than any row block has.
  ResidualDecoder(const FrequencyTables& tables, const RansStreams& streams, std::span<std::uint32_t> large)
      : tables_(tables), streams_(streams), large_(large) {}

  const RansStreams& streams() const { return streams_; }
  // False after symbols that no valid archive holds. Decoding may continue: it stays within memory.
  bool valid() const {
    return class_valid_ && std::none_of(streams_.begin(), streams_.end(), [](const auto& s) { return s.exhausted(); });
  }

  // The residuals of the units of a segment. Stops early if a stream is exhausted.
  void decode(std::span<const CodingUnit> units, std::size_t class_table, AxisVector* residuals) {
    // Local, because the compiler cannot know that storing residuals does not change them.
    const FrequencyTable table = tables_[class_table];
    const AxisVector* const of_symbols = of_symbols_.data();
    std::uint32_t* const large = large_.data();
    std::uint32_t large_count = 0;
    in_turn(units.size(), [=, &large_count](RansStream& stream, std::uint32_t i) {
      const std::uint32_t symbol = stream.symbol(table);
      residuals[i] = of_symbols[symbol];
      // Branch-free: which units are large is unpredictable.
      large[large_count] = i;
      large_count += symbol >= small_unit_symbols;
    });
    in_turn(large_count, [=, this](RansStream& stream, std::uint32_t i) {
      AxisVector& of_unit = residuals[large[i]];
      of_unit = decode_large(stream, units[large[i]], static_cast<std::uint32_t>(of_unit[0]));
    });
  }

 private:
  // Units decoded between two checks for exhausted streams: one takes at most six words at a time.
  static constexpr std::size_t units_per_check = stream_count * (RansStream::padding_words / 8);

  // Calls decode(stream, i) for each i below `count`, with stream i % 4.
  template <class Decode>
  void in_turn(std::size_t count, const Decode& decode) {
    for (std::size_t i = 0; i < count && valid();) {
      const std::size_t end = std::min(i + units_per_check, count);
      // Local, so that the states stay in registers.
      RansStream first = streams_[0], second = streams_[1], third = streams_[2], fourth = streams_[3];
      for (; i + stream_count <= end; i += stream_count) {
        decode(first, static_cast<std::uint32_t>(i));
        decode(second, static_cast<std::uint32_t>(i + 1));
        decode(third, static_cast<std::uint32_t>(i + 2));
        decode(fourth, static_cast<std::uint32_t>(i + 3));
      }
      if (i < end) decode(first, static_cast<std::uint32_t>(i++));
      if (i < end) decode(second, static_cast<std::uint32_t>(i++));
      if (i < end) decode(third, static_cast<std::uint32_t>(i++));
      streams_ = {first, second, third, fourth};
    }
  }

  // The residuals of a unit of class 2 or more.
  AxisVector decode_large(RansStream& stream, const CodingUnit& unit, std::uint32_t unit_class) {
    if (unit_class > max_class) {
      class_valid_ = false;
      return AxisVector{};
    }
    const int offset = (1 << unit_class) - 1;
    const std::uint32_t raw_bits = unit_class > max_coded_bits ? unit_class - max_coded_bits : 0;
    bool class_reached = false;
    const auto next = [&](bool last) {
      std::uint32_t code = stream.symbol(tables_[residual_table(unit_class, last, class_reached)]) << raw_bits;
      if (raw_bits > 0) code |= stream.bits(raw_bits);
      const int residual = static_cast<int>(code) - offset;
      class_reached |= std::abs(residual) > offset / 2;
      return residual;
    };
    if (unit.count == 3) {
      const int x = next(false), y = next(false), z = next(true);
      return AxisVector{x, y, z, 0};
    }
    AxisVector residuals{};
    for (std::uint32_t i = 0; i < unit.count; ++i) residuals[unit.axis + i] = next(i + 1 == unit.count);
    return residuals;
  }

  const std::array<AxisVector, 256> of_symbols_ = residuals_of_class_symbols();
  const FrequencyTables& tables_;
  RansStreams streams_;
  std::span<std::uint32_t> large_;  // the indexes of units of class 2 or more, in the segment
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

  // False after a value out of range, or a residual on an axis that a unit does not have.
  bool valid() const { return !(invalid_[0] | invalid_[1] | invalid_[2]); }

  // `values`: of the segment, one a row.
  void restore(std::span<const CodingUnit> units, const AxisVector* residuals, bool wide, std::int16_t* values) {
    const AxisVector largest = AxisVector{} + (wide ? largest_wide : largest_narrow);
    AxisVector invalid{};  // not 0 on an axis where something is
    for (const CodingUnit& unit : units) {
      AxisVector value = history_.predicted(unit) + *residuals;
      if (unit.count == 3) {
        invalid |= magnitudes(value) > largest;
        store(value, values + unit.row);
      } else {
        const AxisVector present = axis_mask(unit);
        invalid |= (present & (magnitudes(value) > largest)) | (~present & *residuals);
        for (std::uint32_t i = 0; i < unit.count; ++i)
          values[unit.row + i] = static_cast<std::int16_t>(value[unit.axis + i]);
        value = (present & value) | (~present & history_.values(unit.rank));
      }
      history_.set(unit.rank, value << 16 >> 16);  // bounds invalid values until valid() is checked
      ++residuals;
    }
    invalid_ |= invalid;
  }
  // A column is complete: clears the vertices of these units.
  void clear(std::span<const CodingUnit> units) { history_.clear(units); }

 private:
  static void store(AxisVector value, std::int16_t* values) {
    for (std::size_t axis = 0; axis < 3; ++axis) values[axis] = static_cast<std::int16_t>(value[axis]);
  }

  ColumnHistory history_;
  AxisVector invalid_{};
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
        const std::uint32_t pair = count > 1 ? stream.symbol(rans.tables()[pair_table]) : 0;
        if (pair >= pair_index(0, count) || stream.exhausted())
          rans.corrupt(stream, "a vertex has a predictor that does not exist");
        set_predictors(unit, candidates, pair);
      },
      memory);
}

// What a worker decodes a part in, one part after the other.
struct PartWorkspace {
  PartWorkspace(const CodingUnits& units, std::uint32_t vertices, std::pmr::memory_resource& memory)
      : residuals(&memory), large(&memory), restorer(vertices, memory) {
    std::size_t most_units = 0;
    for (const auto& of_block : units) most_units = std::max(most_units, of_block.size());
    residuals.resize(most_units);
    large.resize(most_units + 1);
  }
  std::pmr::vector<AxisVector> residuals;  // of the units of a segment
  std::pmr::vector<std::uint32_t> large;   // see ResidualDecoder
  ValueRestorer restorer;
};

// Decodes the columns of a part. `tables`: the class table of each of their segments.
void read_part(const RansReader& rans, const RansStreams& streams, const CodingUnits& units,
               std::span<const std::pmr::vector<ColumnSegment>> columns, std::span<const std::uint8_t> tables,
               PackedModel& model, PartWorkspace& workspace) {
  auto& [residuals, large, restorer] = workspace;
  ResidualDecoder decoder(rans.tables(), streams, large);
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
