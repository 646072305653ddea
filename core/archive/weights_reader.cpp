#include "archive/layout.h"
#include "archive/section_reader.h"
#include "archive/symbol_reader.h"

namespace fb {
namespace {

template <bool wide>
std::int16_t read_weight(SymbolCursor& in, std::size_t lane, std::uint32_t context) {
  int weight = static_cast<int>(in.symbol(lane, context + (wide ? 3 : 0))) - largest_narrow;
  if (wide) weight = 256 * weight + static_cast<int>(in.symbol(lane, context + 6)) - 128;
  return static_cast<std::int16_t>(weight);
}

// Fills `weights`, unless the words run out before.
template <bool wide>
void read_layer(SymbolCursor& in, std::uint32_t context, std::vector<std::int16_t>& weights) {
  SymbolCursor at = in;
  std::size_t i = 0;
  for (; i + symbol_lanes <= weights.size() && !at.exhausted(); i += symbol_lanes)
    for (std::size_t lane = 0; lane < symbol_lanes; ++lane) weights[i + lane] = read_weight<wide>(at, lane, context);
  for (std::size_t lane = 0; i + lane < weights.size() && !at.exhausted(); ++lane)
    weights[i + lane] = read_weight<wide>(at, lane, context);
  in = at;
}

}  // namespace

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
      layer.wide ? read_layer<true>(at, context, layer.weights) : read_layer<false>(at, context, layer.weights);
    }
  symbols.end(at);
}

}  // namespace fb
