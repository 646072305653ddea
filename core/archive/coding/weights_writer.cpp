#include "archive/coding/symbol_reader.h"
#include "archive/coding/symbol_writer.h"
#include "archive/container/layout.h"
#include "archive/section_writer.h"

namespace fb::archive {

ByteWriter write_weights(const PackedModel& model) {
  SymbolWriter symbols(weight_contexts);
  for (const PackedRegion& region : model.regions)
    for (std::size_t l = 0; l < region.layers.size(); ++l) {
      const PackedLayer& layer = region.layers[l];
      const std::uint32_t context = weight_context(l, region.layers.size());
      for (std::size_t i = 0; i < layer.weights.size(); ++i) {
        symbols.select_stream(i % symbol_streams);
        const int weight = layer.weights[i], digit = layer.wide ? high_digit(weight) : weight;
        symbols.symbol(context + (layer.wide ? 3 : 0), static_cast<std::uint32_t>(digit + largest_narrow));
        if (layer.wide) symbols.symbol(context + 6, static_cast<std::uint32_t>(low_digit(weight) + 128));
      }
    }
  ByteWriter out;
  symbols.write(out);
  return out;
}

}  // namespace fb::archive
