#include "archive/coding/writer/rans_writer.h"

#include <algorithm>
#include <numeric>
#include <span>

namespace fb::archive {
namespace {

// A table's frequencies and the first slot of each symbol.
struct EncodingTable {
  SymbolCounts frequency{}, start{};
};

// Frequencies that sum to table_slots, at least 1 for each symbol that occurs; all 0 if none does.
SymbolCounts normalised(const SymbolCounts& counts) {
  const std::uint64_t total = std::accumulate(counts.begin(), counts.end(), std::uint64_t(0));
  SymbolCounts out{};
  if (total == 0) return out;
  std::uint32_t sum = 0;
  for (std::size_t s = 0; s < out.size(); ++s) {
    if (counts[s] > 0)
      out[s] = std::max<std::uint32_t>(
          1, static_cast<std::uint32_t>((counts[s] * std::uint64_t(table_slots) + total / 2) / total));
    sum += out[s];
  }
  // The rounding error is taken from, or given to, the most frequent symbols.
  for (; sum > table_slots; --sum) --*std::max_element(out.begin(), out.end());
  *std::max_element(out.begin(), out.end()) += table_slots - sum;
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

// The encoder of one stream. Symbols and bits are pushed in reverse order of decoding, as the state is a stack.
class StreamEncoder {
 public:
  void push_bits(std::uint32_t count, std::uint32_t value) {
    renormalise(std::uint64_t(1) << (32 - count));
    state_ = state_ << count | value;
  }
  void push_symbol(std::uint32_t frequency, std::uint32_t start) {
    renormalise(std::uint64_t(frequency) << (32 - table_bits));
    state_ = (state_ / frequency << table_bits) + state_ % frequency + start;
  }
  std::uint32_t state() const { return state_; }
  std::size_t word_count() const { return words_.size(); }
  // In the order of decoding.
  std::vector<std::uint16_t> words() const { return {words_.rbegin(), words_.rend()}; }

 private:
  void renormalise(std::uint64_t limit) {
    if (state_ < limit) return;
    words_.push_back(static_cast<std::uint16_t>(state_));
    state_ >>= 16;
  }

  std::uint32_t state_ = min_state;
  std::vector<std::uint16_t> words_;
};

}  // namespace

std::vector<SymbolCounts> RansWriter::count_symbols() const {
  std::vector<SymbolCounts> counts(tables_);
  for (const Operation& operation : operations_)
    if (operation.raw_bits == 0) ++counts[operation.table][operation.value];
  return counts;
}

void RansWriter::write(ByteWriter& out) const {
  out.number(static_cast<std::uint8_t>(tables_));
  std::vector<EncodingTable> tables;
  for (const SymbolCounts& counts : count_symbols()) {
    EncodingTable& table = tables.emplace_back();
    table.frequency = normalised(counts);
    std::exclusive_scan(table.frequency.begin(), table.frequency.end(), table.start.begin(), 0u);
    write_table(table.frequency, out);
  }
  std::vector<StreamEncoder> streams(parts_ * stream_count);
  for (std::size_t i = operations_.size(); i-- > 0;) {
    const Operation& operation = operations_[i];
    StreamEncoder& stream = streams[operation.stream];
    const EncodingTable& table = tables[operation.table];
    if (operation.raw_bits > 0)
      stream.push_bits(operation.raw_bits, operation.value);
    else
      stream.push_symbol(table.frequency[operation.value], table.start[operation.value]);
  }
  for (std::size_t first = 0; first < streams.size(); first += stream_count) {
    const auto part = std::span(streams).subspan(first, stream_count);
    for (const StreamEncoder& stream : part) out.count(stream.word_count(), "coded words");
    for (const StreamEncoder& stream : part) out.number(stream.state());
  }
  for (const StreamEncoder& stream : streams) out.numbers(stream.words());
}

}  // namespace fb::archive
