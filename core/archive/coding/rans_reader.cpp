#include "archive/coding/rans_reader.h"

#include <algorithm>
#include <numeric>

namespace fb::archive {
namespace {

// One or two bytes, seven bits each.
std::uint32_t read_frequency(ByteReader& in) {
  const std::uint32_t low = in.number<std::uint8_t>("a frequency");
  if (low < 0x80) return low;
  const std::uint32_t high = in.number<std::uint8_t>("a frequency");
  return (low & 0x7f) | high << 7;
}

// Fills one table: the symbol of each slot, and the frequency and first slot of each symbol.
void read_table(ByteReader& in, std::uint8_t* symbol_of_slot, std::uint32_t* frequency_starts) {
  const auto count = in.number<std::uint16_t>("a number of frequencies");
  if (count == 0) {  // symbol 0 always; takes no bits
    frequency_starts[0] = table_slots << 16;
    return;
  }
  const std::uint32_t first = in.number<std::uint8_t>("a symbol");
  if (first + count > 256) in.corrupt("a symbol does not fit a byte");
  std::uint32_t slot = 0;
  for (std::uint32_t symbol = first; symbol < first + count; ++symbol) {
    const std::uint32_t frequency = read_frequency(in);
    if (frequency > table_slots - slot) in.corrupt("the frequencies of symbols are too large");
    frequency_starts[symbol] = frequency << 16 | slot;
    std::fill_n(symbol_of_slot + slot, frequency, static_cast<std::uint8_t>(symbol));
    slot += frequency;
  }
  if (slot != table_slots) in.corrupt("the frequencies of symbols are too small");
}

}  // namespace

RansReader::RansReader(ByteReader& in, TableLimits limits, std::size_t parts)
    : in_(&in),
      tables_{std::pmr::vector<std::uint8_t>(&in.budget()), std::pmr::vector<std::uint32_t>(&in.budget())},
      words_(&in.budget()),
      parts_(parts) {
  const std::size_t tables = in.number<std::uint8_t>("a number of tables");
  if (tables < limits.fewest || tables > limits.most) in.corrupt("the section has no such number of tables");
  tables_.symbol_of_slot.resize(tables * table_slots);
  tables_.frequency_starts.resize(tables * 256);
  for (std::size_t table = 0; table < tables; ++table)
    read_table(in, &tables_.symbol_of_slot[table * table_slots], &tables_.frequency_starts[table * 256]);

  std::vector<std::uint32_t> counts;
  for (RansStreams& streams : parts_) {
    for (std::size_t s = 0; s < stream_count; ++s) counts.push_back(in.number<std::uint32_t>("a number of words"));
    for (RansStream& stream : streams) {
      stream.state_ = in.number<std::uint32_t>("a stream's state");
      if (stream.state_ < min_state) in.corrupt("a stream's state is too small");
    }
  }
  const std::uint64_t words = std::accumulate(counts.begin(), counts.end(), std::uint64_t(0));
  if (in.left() != 2 * words) in.corrupt("the words of the streams do not fill the section");
  words_ = in.temporary_numbers<std::uint16_t>(words, "coded symbols", RansStream::padding_words);
  const std::uint16_t* word = words_.data();
  auto count = counts.begin();
  for (RansStreams& streams : parts_)
    for (RansStream& stream : streams) {
      stream.word_ = word;
      stream.end_ = word += *count++;
    }
}

void RansReader::corrupt(const RansStream& stream, const char* what) const {
  in_->corrupt(stream.exhausted() ? "there are too few coded symbols" : what);
}

void RansReader::corrupt(const RansStreams& streams, const char* what) const {
  for (const RansStream& stream : streams)
    if (stream.exhausted()) corrupt(stream, what);
  in_->corrupt(what);
}

void RansReader::end(const RansStreams& streams) const {
  for (const RansStream& stream : streams) {
    if (stream.exhausted()) corrupt(stream, "");
    if (stream.word_ != stream.end_) in_->corrupt("there are too many coded symbols");
    if (stream.state_ != min_state) in_->corrupt("a stream does not end in its final state");
  }
}

}  // namespace fb::archive
