#include <algorithm>
#include <bit>
#include <cstdlib>
#include <type_traits>

#include "archive/basis_coding.h"
#include "archive/layout.h"
#include "archive/section_reader.h"
#include "archive/symbol_reader.h"

namespace fb {
namespace {

// Damage, where the order would not name each vertex once.
void read_order(ByteReader& in, std::uint32_t vertices, std::vector<std::uint32_t>& order) {
  order = in.planes32(vertices, "the order");
  std::vector<bool> named(vertices);
  std::uint32_t vertex = 0;
  for (std::uint32_t& step : order) {
    step = vertex += from_zigzag(step);
    if (vertex >= vertices || named[vertex]) in.damaged("the order does not name every vertex once");
    named[vertex] = true;
  }
}

void read_rows(ByteReader& in, std::uint32_t vertices, PackedModel& model) {
  const std::vector<std::uint32_t> rows = in.planes32(in.count(4, "row groups"), "row counts");
  in.budget().take(rows.size(), sizeof(PackedRowGroup), "row groups");
  model.groups.resize(rows.size());
  std::uint64_t row = 0;
  for (std::size_t g = 0; g < rows.size(); ++g) {
    model.groups[g].first_row = static_cast<std::uint32_t>(row);
    model.groups[g].row_count = rows[g];
    row += rows[g];
    if (row > 3 * std::uint64_t(vertices)) break;
  }
  if (row != 3 * std::uint64_t(vertices)) in.damaged("row groups do not add up to the number of rows");
}

// Reads `count` rows, which is a constant where it can be. False for what no writer gives.
template <class Count>
inline bool read_piece(SymbolCursor& in, ColumnState& state, const BasisPiece& piece, Count count,
                       std::int16_t* values) {
  const std::uint32_t bits = in.symbol(class_lane, state.class_context(piece));
  if (bits > state.most_class()) return false;
  int residuals[3] = {};
  if (bits > 0) {
    const int reach = (1 << bits) - 1;
    const std::uint32_t finer = bits > coded_bits ? bits - coded_bits : 0;
    bool reached = false;
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t level = state.level(piece, piece.axis + i);
      std::uint32_t code = in.symbol(i, ColumnState::residual_context(bits, level, i + 1 == count, reached)) << finer;
      if (finer > 0) code |= in.bits(i, finer);
      residuals[i] = static_cast<int>(code) - reach;
      reached = reached || std::abs(residuals[i]) > reach / 2;
    }
  }
  std::uint32_t digits = 0;
  bool within = true;
  for (std::uint32_t i = 0; i < count; ++i) {
    const int number = state.foretold(piece, piece.axis + i) + residuals[i];
    digits |= static_cast<std::uint32_t>(std::abs(number));
    within &= std::abs(number) <= state.largest();
    state.set(piece.vertex, piece.axis + i, number, residuals[i]);
    values[piece.row + i] = static_cast<std::int16_t>(number);
  }
  state.done(piece.vertex, bits, digits);
  return within;
}

// Seven words are read for a piece at most.
constexpr std::size_t pieces_at_once = SymbolCursor::spare_words / 8;

bool read_place(SymbolCursor& in, ColumnState& state, const std::vector<BasisPiece>& pieces, std::int16_t* values) {
  SymbolCursor at = in;
  bool sound = true;
  for (std::size_t first = 0; sound && first < pieces.size(); first += pieces_at_once) {
    for (std::size_t p = first; sound && p < std::min(first + pieces_at_once, pieces.size()); ++p)
      sound = pieces[p].count == 3
                  ? read_piece(at, state, pieces[p], std::integral_constant<std::uint32_t, 3>(), values)
                  : read_piece(at, state, pieces[p], std::uint32_t(pieces[p].count), values);
    sound &= !at.exhausted();
  }
  in = at;
  return sound;
}

}  // namespace

void read_basis(ByteReader& in, std::uint32_t vertices, PackedModel& model) {
  const std::uint32_t columns = in.count(4, "columns");
  const auto ordered = in.number<std::uint32_t>("the order flag");
  if (ordered > 1) in.damaged("the order flag is neither 0 nor 1");
  if (ordered) read_order(in, vertices, model.order);
  read_rows(in, vertices, model);
  const std::vector<std::uint32_t> counts = in.planes32(columns, "places of columns");
  std::uint64_t places = 0;
  for (const std::uint32_t count : counts) places += count;
  const std::vector<std::uint32_t> steps = in.planes32(places, "group steps");
  const std::vector<std::uint8_t> flags = in.numbers<std::uint8_t>(places, "flags");
  const std::uint32_t stated = in.count(4, "scales");
  const std::vector<float> scales = in.float_planes(stated, "scales");
  in.end();

  in.budget().take(places, sizeof(PackedColumn), "columns");
  model.columns = columns;
  std::size_t at = 0, next_scale = 0;
  for (std::uint32_t c = 0; c < columns; ++c) {
    std::uint64_t group = 0;
    for (std::uint32_t i = 0; i < counts[c]; ++i, ++at) {
      if (i > 0 && steps[at] == 0) in.damaged("a column lies twice in one row group");
      group += steps[at];
      if (group >= model.groups.size()) in.damaged("a column lies in a row group that does not exist");
      if (flags[at] & ~(place_is_wide | place_has_scale))
        fail(Status::unsupported, "%s has a column of unknown flags 0x%x", in.where().c_str(), flags[at]);
      if (flags[at] & place_has_scale) ++next_scale;
      if (next_scale == 0 || next_scale > scales.size()) in.damaged("a column has no scale");
      model.groups[group].columns.push_back({c, (flags[at] & place_is_wide) != 0, scales[next_scale - 1]});
    }
  }
  if (next_scale != scales.size()) in.damaged("there are more scales than columns use");
}

void read_basis_values(ByteReader& in, std::uint32_t vertices, PackedModel& model) {
  for (PackedRowGroup& group : model.groups) {
    const std::size_t count = checked_multiply(group.columns.size(), group.row_count, in.where().c_str());
    in.budget().take(count, sizeof(std::int16_t), "basis values");
    group.values.resize(count);
  }
  in.budget().take(vertices, 192, "predictions");  // about: pieces, neighbours, one column
  const SymbolReader symbols(in, basis_contexts);
  SymbolCursor at = symbols.begin();
  const auto pieces = basis_pieces(model.rest, vertices, model.order, model.groups);
  ColumnState state(vertices);
  for (const std::vector<ColumnPlace>& places : column_places(model)) {
    for (const ColumnPlace& place : places) {
      PackedRowGroup& group = model.groups[place.group];
      std::int16_t* const values = group.values.data() + std::size_t(place.index) * group.row_count;
      state.begin_place(group.columns[place.index].wide);
      if (!read_place(at, state, pieces[place.group], values))
        symbols.refuse(at, "the basis holds a value beyond its range");
    }
    for (const ColumnPlace& place : places) state.forget(pieces[place.group]);
  }
  symbols.end(at);
}

}  // namespace fb
