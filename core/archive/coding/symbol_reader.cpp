#include "archive/coding/symbol_reader.h"

#include <algorithm>
#include <numeric>

namespace fb::archive {
namespace {

std::uint32_t read_frequency(ByteReader& in) {
  const std::uint32_t low = in.number<std::uint8_t>("a frequency");
  if (low < 0x80) return low;
  const std::uint32_t high = in.number<std::uint8_t>("a frequency");
  return (low & 0x7f) | high << 7;
}

// The symbol of each slot, and of each symbol its first slot plus 65536 times its frequency.
void read_table(ByteReader& in, std::uint8_t* symbols, std::uint32_t* shares) {
  const auto count = in.number<std::uint16_t>("a number of frequencies");
  if (count == 0) {  // always 0, at no cost
    shares[0] = symbol_slots << 16;
    return;
  }
  const std::uint32_t first = in.number<std::uint8_t>("a symbol");
  if (first + count > 256) in.damaged("a symbol does not fit a byte");
  std::uint32_t slot = 0;
  for (std::uint32_t symbol = first; symbol < first + count; ++symbol) {
    const std::uint32_t frequency = read_frequency(in);
    if (frequency > symbol_slots - slot) in.damaged("the frequencies of symbols are too large");
    shares[symbol] = frequency << 16 | slot;
    std::fill_n(symbols + slot, frequency, static_cast<std::uint8_t>(symbol));
    slot += frequency;
  }
  if (slot != symbol_slots) in.damaged("the frequencies of symbols are too small");
}

}  // namespace

SymbolReader::SymbolReader(ByteReader& in, std::size_t contexts) : in_(&in) {
  tables_.of_context = in.numbers<std::uint8_t>(contexts, "tables of contexts");
  const std::size_t tables = *std::max_element(tables_.of_context.begin(), tables_.of_context.end()) + std::size_t(1);
  if (tables > most_tables) in.damaged("contexts have more tables than the format allows");
  in.budget().take(tables, symbol_slots + 256 * sizeof(std::uint32_t), "symbol tables");
  tables_.symbols.resize(tables * symbol_slots);
  tables_.shares.resize(tables * 256);
  for (std::size_t table = 0; table < tables; ++table)
    read_table(in, &tables_.symbols[table * symbol_slots], &tables_.shares[table * 256]);

  std::array<std::uint32_t, symbol_streams> counts;
  for (std::uint32_t& count : counts) count = in.number<std::uint32_t>("a number of words");
  for (SymbolStream& stream : begin_) {
    stream.state_ = in.number<std::uint32_t>("a coder's state");
    if (stream.state_ < least_state) in.damaged("a coder's state is too small");
  }
  const std::uint64_t words = std::accumulate(counts.begin(), counts.end(), std::uint64_t(0));
  if (in.left() != 2 * words) in.damaged("the words of the streams do not fill the section");
  words_ = in.numbers<std::uint16_t>(words, "coded symbols");
  words_.resize(words_.size() + SymbolStream::spare_words);
  const std::uint16_t* at = words_.data();
  for (std::size_t stream = 0; stream < symbol_streams; ++stream) {
    begin_[stream].at_ = at;
    begin_[stream].end_ = at += counts[stream];
  }
}

void SymbolReader::refuse(const SymbolStream& stream, const char* what) const {
  in_->damaged(stream.exhausted() ? "there are too few coded symbols" : what);
}

void SymbolReader::end(const SymbolStreams& streams) const {
  for (const SymbolStream& stream : streams) {
    if (stream.exhausted()) refuse(stream, "");
    if (stream.at_ != stream.end_) in_->damaged("there are too many coded symbols");
    if (stream.state_ != least_state) in_->damaged("the coded symbols do not end as they should");
  }
}

}  // namespace fb::archive
