#include "archive/coding/symbol_writer.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "archive/coding/context_clustering.h"
#include "archive/coding/symbol_reader.h"
#include "base/checked.h"

namespace fb::archive {
namespace {

// Frequencies that sum to symbol_slots, at least 1 for whatever occurs; all 0 if nothing does.
SymbolCounts frequencies(const SymbolCounts& counts) {
  const std::uint64_t total = std::accumulate(counts.begin(), counts.end(), std::uint64_t(0));
  SymbolCounts out{};
  if (total == 0) return out;
  std::uint32_t sum = 0;
  for (std::size_t s = 0; s < out.size(); ++s) {
    if (counts[s] > 0)
      out[s] = std::max<std::uint32_t>(
          1, static_cast<std::uint32_t>((counts[s] * std::uint64_t(symbol_slots) + total / 2) / total));
    sum += out[s];
  }
  // What rounding gave or took is taken from or given to the most frequent.
  for (; sum > symbol_slots; --sum) --*std::max_element(out.begin(), out.end());
  *std::max_element(out.begin(), out.end()) += symbol_slots - sum;
  return out;
}

void write_table(const SymbolCounts& frequency, ByteWriter& out) {
  std::uint32_t first = 0, end = 256;
  while (first < end && frequency[first] == 0) ++first;
  while (end > first && frequency[end - 1] == 0) --end;
  out.number(static_cast<std::uint16_t>(end - first));
  if (first == end) return;
  out.number(static_cast<std::uint8_t>(first));
  for (std::uint32_t s = first; s < end; ++s) {
    if (frequency[s] < 0x80) {
      out.number(static_cast<std::uint8_t>(frequency[s]));
    } else {
      out.number(static_cast<std::uint8_t>(0x80 | frequency[s] % 0x80));
      out.number(static_cast<std::uint8_t>(frequency[s] / 0x80));
    }
  }
}

}  // namespace

void SymbolWriter::write(ByteWriter& out) const {
  std::vector<SymbolCounts> counts(contexts_);
  for (const Step& step : steps_)
    if (step.plain_bits == 0) ++counts[step.context][step.value];
  const std::vector<std::uint8_t> table_of = cluster_contexts(counts);
  out.numbers(table_of);
  std::vector<SymbolCounts> frequency(1 + *std::max_element(table_of.begin(), table_of.end())), first(frequency.size());
  for (std::size_t c = 0; c < contexts_; ++c)
    for (std::size_t s = 0; s < counts[c].size(); ++s) frequency[table_of[c]][s] += counts[c][s];
  for (std::size_t t = 0; t < frequency.size(); ++t) {
    frequency[t] = frequencies(frequency[t]);
    std::exclusive_scan(frequency[t].begin(), frequency[t].end(), first[t].begin(), 0u);
    write_table(frequency[t], out);
  }
  // Backwards, as the numeral system is a stack: what is put in last comes out first.
  std::array<std::uint32_t, symbol_streams> states;
  states.fill(least_state);
  std::array<std::vector<std::uint16_t>, symbol_streams> words;
  for (std::size_t i = steps_.size(); i-- > 0;) {
    const auto& [context, stream, plain_bits, value] = steps_[i];
    std::uint32_t& state = states[stream];
    const auto make_room = [&, stream = stream](std::uint64_t beyond) {
      if (state < beyond) return;
      words[stream].push_back(static_cast<std::uint16_t>(state));
      state >>= 16;
    };
    if (plain_bits > 0) {
      make_room(std::uint64_t(1) << (32 - plain_bits));
      state = state << plain_bits | value;
    } else {
      const std::uint32_t share = frequency[table_of[context]][value];
      make_room(std::uint64_t(share) << (32 - symbol_bits));
      state = (state / share << symbol_bits) + state % share + first[table_of[context]][value];
    }
  }
  for (const auto& of_lane : words) out.number(checked_u32(of_lane.size(), "coded words"));
  for (const std::uint32_t state : states) out.number(state);
  for (auto& of_lane : words) {
    std::reverse(of_lane.begin(), of_lane.end());
    out.numbers(of_lane);
  }
}

}  // namespace fb::archive
