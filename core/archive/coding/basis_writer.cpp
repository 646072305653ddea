#include <bit>

#include "archive/coding/basis_symbols.h"
#include "archive/coding/choose_predictors.h"
#include "archive/coding/symbol_writer.h"
#include "archive/container/layout.h"
#include "archive/section_writer.h"
#include "base/checked.h"

namespace fb::archive {
namespace {

void write_column(SymbolWriter& out, ColumnState& state, const std::vector<BasisPiece>& pieces, bool wide,
                  const std::int16_t* values) {
  state.begin_place(wide);
  for (const BasisPiece& piece : pieces) {
    const AxisNumbers numbers = numbers_of(state, piece, values + piece.row);
    const AxisNumbers residuals = residuals_of(state, piece, numbers);
    code_piece(out, state, piece, residuals);
    state.set(piece.slot, numbers, residuals, class_of(residuals));
  }
}

}  // namespace

ByteWriter write_basis(const PackedModel& model) {
  ByteWriter out;
  out.number(model.columns);
  out.number(std::uint32_t(!model.order.empty()));
  std::vector<std::uint32_t> numbers;
  std::uint32_t before = 0;
  for (const std::uint32_t vertex : model.order) {
    numbers.push_back(to_zigzag(vertex - before));
    before = vertex;
  }
  out.planes(numbers);
  numbers.clear();
  out.number(checked_u32(model.groups.size(), "row groups"));
  for (const PackedRowBlock& group : model.groups) numbers.push_back(group.row_count);
  out.planes(numbers);
  numbers.clear();

  std::vector<std::uint32_t> steps;
  std::vector<std::uint8_t> flags;
  std::vector<float> scales;
  for (const std::vector<ColumnPlace>& places : column_places(model)) {
    numbers.push_back(checked_u32(places.size(), "places"));
    before = 0;
    for (const auto& [g, index] : places) {
      const PackedColumn& column = model.groups[g].columns[index];
      steps.push_back(g - before);
      before = g;
      const bool stated =
          scales.empty() || std::bit_cast<std::uint32_t>(scales.back()) != std::bit_cast<std::uint32_t>(column.scale);
      flags.push_back(static_cast<std::uint8_t>((column.wide ? place_is_wide : 0) | (stated ? place_has_scale : 0)));
      if (stated) scales.push_back(column.scale);
    }
  }
  out.planes(numbers);
  out.planes(steps);
  out.numbers(flags);
  out.number(checked_u32(scales.size(), "scales"));
  out.planes(scales);
  return out;
}

ByteWriter write_basis_values(const PackedModel& model) {
  const auto pieces = best_pieces(model);
  SymbolWriter symbols(basis_contexts);
  for (const auto& of_group : pieces)
    for (const BasisPiece& piece : of_group)
      if (piece.predictor_count > 1) symbols.symbol(choice_context(piece), piece.choice);
  ColumnState state(model.rest.vertex_count());
  const auto places = column_places(model);
  const auto streams = columns_of_streams(model, places);
  for (std::size_t stream = 0; stream < symbol_streams; ++stream) {
    symbols.select_stream(stream);
    for (std::size_t c = streams[stream]; c < streams[stream + 1]; ++c) {
      for (const auto& [g, index] : places[c]) {
        const PackedRowBlock& group = model.groups[g];
        write_column(symbols, state, pieces[g], group.columns[index].wide,
                     group.values.data() + std::size_t(index) * group.row_count);
      }
      for (const ColumnPlace& place : places[c]) state.forget(pieces[place.group]);
    }
  }
  ByteWriter out;
  symbols.write(out);
  return out;
}

}  // namespace fb::archive
