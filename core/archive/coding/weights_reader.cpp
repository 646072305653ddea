#include <algorithm>

#include "archive/coding/coding_reader.h"
#include "archive/coding/coding_symbols.h"
#include "archive/coding/rans_reader.h"

namespace fb::archive {
namespace {

// Weights read between two checks for exhausted streams: a weight takes at most two words.
constexpr std::size_t weights_per_check = stream_count * RansStream::padding_words / 2;

template <bool wide>
std::int16_t read_weight(const FrequencyTables& tables, RansStream& in, std::uint32_t table) {
  int weight = static_cast<int>(in.symbol(tables[table + (wide ? high_digit_tables : 0)])) - largest_narrow;
  if (wide) weight = 256 * weight + static_cast<int>(in.symbol(tables[table + low_digit_tables])) - 128;
  return static_cast<std::int16_t>(weight);
}

// Fills `weights`; false if a stream is exhausted. `streams` is copied so that its states stay in registers.
template <bool wide>
bool read_layer(const FrequencyTables& tables, RansStreams& streams, std::uint32_t table,
                std::pmr::vector<std::int16_t>& weights) {
  RansStreams local = streams;
  const auto valid = [&] {
    return std::none_of(local.begin(), local.end(), [](const auto& stream) { return stream.exhausted(); });
  };
  for (std::size_t i = 0; i < weights.size() && valid();)
    for (const std::size_t end = std::min(i + weights_per_check, weights.size()); i < end;)
      for (std::size_t stream = 0; stream < stream_count && i < end; ++stream, ++i)
        weights[i] = read_weight<wide>(tables, local[stream], table);
  streams = local;
  return valid();
}

}  // namespace

void read_weights(ByteReader& in, PackedModel& model) {
  const RansReader rans(in, {weight_tables, weight_tables}, 1);
  RansStreams streams = rans.streams(0);
  for (PackedRegion& region : model.regions)
    for (std::size_t l = 0; l < region.layers.size(); ++l) {
      PackedLayer& layer = region.layers[l];
      const std::size_t count = checked_multiply(layer.inputs, layer.outputs, in.where().c_str());
      in.budget().resize(layer.weights, count, "weights");
      const std::uint32_t table = weight_table(l, region.layers.size());
      const auto read = layer.wide ? read_layer<true> : read_layer<false>;
      if (!read(rans.tables(), streams, table, layer.weights)) rans.end(streams);
    }
  rans.end(streams);
}

}  // namespace fb::archive
