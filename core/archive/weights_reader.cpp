#include "archive/layout.h"
#include "archive/section_reader.h"
#include "archive/symbol_reader.h"

namespace fb {

void read_weights(ByteReader& in, PackedModel& model) {
  const SymbolReader symbols(in, weight_contexts);
  SymbolCursor at = symbols.begin();
  for (PackedRegion& region : model.regions)
    for (std::size_t l = 0; l < region.layers.size(); ++l) {
      PackedLayer& layer = region.layers[l];
      const std::size_t count = checked_multiply(layer.inputs, layer.outputs, in.where().c_str());
      in.budget().take(count, sizeof(std::int16_t), "weights");
      layer.weights.resize(count);
      const std::uint32_t context = weight_context(l, region.layers.size());
      for (std::size_t i = 0; i < count; ++i) {
        const std::size_t lane = i % symbol_lanes;
        int weight = static_cast<int>(at.symbol(lane, context + (layer.wide ? 3 : 0))) - largest_narrow;
        if (layer.wide) weight = 256 * weight + static_cast<int>(at.symbol(lane, context + 6)) - 128;
        layer.weights[i] = static_cast<std::int16_t>(weight);
      }
    }
  symbols.end(at);
}

}  // namespace fb
