#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <span>
#include <type_traits>

#include "archive/coding/basis_coding.h"
#include "archive/coding/symbol_reader.h"
#include "archive/container/layout.h"
#include "archive/section_reader.h"

namespace fb::archive {
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
  in.budget().take(rows.size(), sizeof(PackedRowBlock), "row groups");
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

// What the first symbol of a piece is read with: of each context_key its table, and the residuals of small pieces.
struct FirstSymbols {
  explicit FirstSymbols(const SymbolTables& tables) {
    for (std::uint32_t s = 0; s < context_keys; ++s) table[s] = tables.of_context[first_context(s)];
    for (std::uint32_t s = 0; s < small_pieces; ++s)
      residuals[s] = AxisNumbers{small_residuals[s % 3], small_residuals[s / 3 % 3], small_residuals[s / 9], 0};
  }
  std::array<std::uint8_t, context_keys> table;
  std::array<AxisNumbers, small_pieces> residuals;
};

// Reads the columns of one stream, piece after piece.
class StreamReader {
 public:
  StreamReader(PackedModel& model, std::uint32_t vertices, const SymbolTables& tables, const FirstSymbols& firsts,
               const std::vector<std::vector<BasisPiece>>& pieces, std::span<const std::vector<ColumnPlace>> columns,
               const SymbolStream& symbols)
      : symbols_(symbols),
        tables_(tables),
        firsts_(firsts),
        state_(vertices),
        model_(model),
        pieces_(pieces),
        columns_(columns) {
    go_on();
  }

  const SymbolStream& symbols() const { return symbols_; }
  // Pieces that are left of a place; 0 only in the end.
  std::size_t left() const { return static_cast<std::size_t>(end_ - piece_); }
  // False after what no writer gives.
  bool sound() const { return sound_ && !symbols_.exhausted() && !(beyond_[0] | beyond_[1] | beyond_[2]); }

  // Reads a piece.
  void read() {
    const BasisPiece& piece = *piece_++;
    const std::uint32_t first = symbols_.symbol_of(tables_, firsts_.table[state_.context_key(piece)]);
    AxisNumbers residuals;
    std::uint32_t bits = first > 0;
    if (first < small_pieces) {
      residuals = firsts_.residuals[first];
    } else {
      bits = first - class_symbols;
      residuals = piece.count == 3 ? read_residuals(piece, std::integral_constant<std::uint32_t, 0>(),
                                                    std::integral_constant<std::uint32_t, 3>(), bits)
                                   : read_residuals(piece, std::uint32_t(piece.axis), std::uint32_t(piece.count), bits);
    }
    AxisNumbers numbers = state_.predicted(piece) + residuals;
    const AxisNumbers own = piece.count == 3 ? AxisNumbers{-1, -1, -1, -1} : axes_of(piece);
    beyond_ |= (own & (magnitudes(numbers) > state_.largest())) | (~own & residuals);
    numbers = numbers << 16 >> 16;  // so that what is beyond its range does not grow until that is asked for
    if (piece.count < 3) numbers = (own & numbers) | (~own & state_.numbers(piece.slot));
    if (piece.count == 3)
      for (std::size_t axis = 0; axis < 3; ++axis) values_[piece.row + axis] = static_cast<std::int16_t>(numbers[axis]);
    else
      for (std::uint32_t i = 0; i < piece.count; ++i)
        values_[piece.row + i] = static_cast<std::int16_t>(numbers[piece.axis + i]);
    state_.set(piece.slot, numbers, residuals, bits);
  }

  // To the next place, where nothing is left of this one.
  void go_on() {
    if (left() > 0) return;
    while (column_ < columns_.size() && place_ == columns_[column_].size()) {
      for (const ColumnPlace& place : columns_[column_]) state_.forget(pieces_[place.group]);
      ++column_;
      place_ = 0;
    }
    if (column_ == columns_.size()) return;
    const auto [g, index] = columns_[column_][place_++];
    PackedRowBlock& group = model_.groups[g];
    values_ = group.values.data() + std::size_t(index) * group.row_count;
    state_.begin_place(group.columns[index].wide);
    piece_ = pieces_[g].data();
    end_ = piece_ + pieces_[g].size();
  }

 private:
  // Of a piece of `count` rows, which is a constant where it can be, as is the first axis.
  template <class Axis, class Count>
  AxisNumbers read_residuals(const BasisPiece& piece, Axis first_axis, Count count, std::uint32_t& bits) {
    if (bits > most_class) {
      sound_ = false;
      bits = 2;
    }
    std::int32_t residuals[3] = {};
    const int reach = (1 << bits) - 1;
    const std::uint32_t finer = bits > coded_bits ? bits - coded_bits : 0;
    bool reached = false;
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t level = state_.level(piece, first_axis + i);
      std::uint32_t code = symbols_.symbol(tables_, ColumnState::residual_context(bits, level, i + 1 == count, reached))
                           << finer;
      if (finer > 0) code |= symbols_.bits(finer);
      residuals[first_axis + i] = static_cast<int>(code) - reach;
      reached = reached || std::abs(residuals[first_axis + i]) > reach / 2;
    }
    return AxisNumbers{residuals[0], residuals[1], residuals[2], 0};
  }

  // All bits of the axes that a piece has.
  static AxisNumbers axes_of(const BasisPiece& piece) {
    AxisNumbers own{};
    for (std::uint32_t i = 0; i < piece.count; ++i) own[piece.axis + i] = -1;
    return own;
  }

  SymbolStream symbols_;
  const BasisPiece *piece_ = nullptr, *end_ = nullptr;
  std::int16_t* values_ = nullptr;
  bool sound_ = true;
  AxisNumbers beyond_{};  // not 0 after numbers beyond their range
  const SymbolTables& tables_;
  const FirstSymbols& firsts_;
  ColumnState state_;
  PackedModel& model_;
  const std::vector<std::vector<BasisPiece>>& pieces_;
  std::span<const std::vector<ColumnPlace>> columns_;
  std::size_t column_ = 0, place_ = 0;  // the place to come
};

// Seven words are read for a piece at most.
constexpr std::size_t pieces_at_once = SymbolStream::spare_words / 8;

// Reads all streams side by side: a processor goes on in the others while it waits for what one of them needs next.
// Leaves a stream that is not sound, and others then unfinished.
void read_streams(std::vector<StreamReader>& streams) {
  std::vector<StreamReader*> going;
  for (StreamReader& stream : streams) going.push_back(&stream);
  for (;;) {
    std::erase_if(going, [](const StreamReader* stream) { return stream->left() == 0; });
    if (going.empty() || !std::all_of(going.begin(), going.end(), [](auto* stream) { return stream->sound(); })) return;
    std::size_t pieces = pieces_at_once;
    for (const StreamReader* stream : going) pieces = std::min(pieces, stream->left());
    for (; pieces > 0; --pieces)
      for (StreamReader* const stream : going) stream->read();
    for (StreamReader* const stream : going) stream->go_on();
  }
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
  for (PackedRowBlock& group : model.groups) {
    const std::size_t count = checked_multiply(group.columns.size(), group.row_count, in.where().c_str());
    in.budget().take(count, sizeof(std::int16_t), "basis values");
    group.values.resize(count);
  }
  in.budget().take(vertices, 320, "predictions");  // about: pieces, neighbours, a column of each stream
  const SymbolReader symbols(in, basis_contexts);
  SymbolStreams at = symbols.begin();
  const auto pieces = basis_pieces(
      model.rest, vertices, model.order, model.groups, [&](BasisPiece& piece, std::span<const Predictor> predictors) {
        const std::uint32_t choice = predictors.size() > 1 ? at[0].symbol(symbols.tables(), choice_context(piece)) : 0;
        const auto count = static_cast<std::uint32_t>(predictors.size());
        if (choice >= pair_number(0, count) || at[0].exhausted())
          symbols.refuse(at[0], "a vertex is predicted from what is not there");
        choose_pair(piece, predictors, choice);
      });
  const auto places = column_places(model);
  const auto columns = columns_of_streams(model, places);
  const FirstSymbols firsts(symbols.tables());
  std::vector<StreamReader> streams;
  streams.reserve(symbol_streams);
  for (std::size_t stream = 0; stream < symbol_streams; ++stream)
    streams.emplace_back(model, vertices, symbols.tables(), firsts, pieces,
                         std::span(places).subspan(columns[stream], columns[stream + 1] - columns[stream]), at[stream]);
  read_streams(streams);
  for (std::size_t stream = 0; stream < symbol_streams; ++stream) {
    if (!streams[stream].sound()) symbols.refuse(streams[stream].symbols(), "the basis holds a value beyond its range");
    at[stream] = streams[stream].symbols();
  }
  symbols.end(at);
}

}  // namespace fb::archive
