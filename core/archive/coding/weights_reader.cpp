#include <algorithm>

#include "archive/coding/symbol_reader.h"
#include "archive/container/layout.h"
#include "archive/section_reader.h"

namespace fb::archive {
namespace {

// Two words are read for a weight at most.
constexpr std::size_t weights_at_once = symbol_streams * SymbolStream::spare_words / 2;

template <bool wide>
std::int16_t read_weight(const SymbolTables& tables, SymbolStream& in, std::uint32_t context) {
  int weight = static_cast<int>(in.symbol(tables, context + (wide ? 3 : 0))) - largest_narrow;
  if (wide) weight = 256 * weight + static_cast<int>(in.symbol(tables, context + 6)) - 128;
  return static_cast<std::int16_t>(weight);
}

// Fills `weights`; false if the words run out before.
template <bool wide>
bool read_layer(const SymbolTables& tables, SymbolStreams& in, std::uint32_t context,
                std::vector<std::int16_t>& weights) {
  SymbolStreams at = in;
  const auto sound = [&] {
    return std::none_of(at.begin(), at.end(), [](const auto& stream) { return stream.exhausted(); });
  };
  for (std::size_t i = 0; i < weights.size() && sound();)
    for (const std::size_t end = std::min(i + weights_at_once, weights.size()); i < end;)
      for (std::size_t stream = 0; stream < symbol_streams && i < end; ++stream, ++i)
        weights[i] = read_weight<wide>(tables, at[stream], context);
  in = at;
  return sound();
}

}  // namespace

void read_weights(ByteReader& in, PackedModel& model) {
  const SymbolReader symbols(in, weight_contexts);
  SymbolStreams at = symbols.begin();
  for (PackedRegion& region : model.regions)
    for (std::size_t l = 0; l < region.layers.size(); ++l) {
      PackedLayer& layer = region.layers[l];
      const std::size_t count = checked_multiply(layer.inputs, layer.outputs, in.where().c_str());
      in.budget().take(count, sizeof(std::int16_t), "weights");
      layer.weights.resize(count);
      const std::uint32_t context = weight_context(l, region.layers.size());
      const auto read = layer.wide ? read_layer<true> : read_layer<false>;
      if (!read(symbols.tables(), at, context, layer.weights)) symbols.end(at);
    }
  symbols.end(at);
}

}  // namespace fb::archive
