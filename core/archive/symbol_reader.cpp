#include "archive/symbol_reader.h"

#include <algorithm>

namespace fb {
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
  tables_ = in.numbers<std::uint8_t>(contexts, "tables of contexts");
  const std::size_t tables = *std::max_element(tables_.begin(), tables_.end()) + std::size_t(1);
  if (tables > most_tables) in.damaged("contexts have more tables than the format allows");
  in.budget().take(tables, symbol_slots + 256 * sizeof(std::uint32_t), "symbol tables");
  symbols_.resize(tables * symbol_slots);
  shares_.resize(tables * 256);
  for (std::size_t table = 0; table < tables; ++table)
    read_table(in, &symbols_[table * symbol_slots], &shares_[table * 256]);

  for (std::uint32_t& state : begin_.states_) {
    state = in.number<std::uint32_t>("a coder's state");
    if (state < least_state) in.damaged("a coder's state is too small");
  }
  if (in.left() % 2 != 0) in.damaged("there are too many coded symbols, by half a word");
  words_ = in.numbers<std::uint16_t>(in.left() / 2, "coded symbols");
  const std::size_t count = words_.size();
  words_.resize(count + SymbolCursor::spare_words);
  begin_.tables_ = tables_.data();
  begin_.symbols_ = symbols_.data();
  begin_.shares_ = shares_.data();
  begin_.at_ = words_.data();
  begin_.end_ = words_.data() + count;
}

void SymbolReader::refuse(const SymbolCursor& cursor, const char* what) const {
  in_->damaged(cursor.exhausted() ? "there are too few coded symbols" : what);
}

void SymbolReader::end(const SymbolCursor& cursor) const {
  if (cursor.exhausted()) refuse(cursor, "");
  if (cursor.at_ != cursor.end_) in_->damaged("there are too many coded symbols");
  for (const std::uint32_t state : cursor.states_)
    if (state != least_state) in_->damaged("the coded symbols do not end as they should");
}

}  // namespace fb
