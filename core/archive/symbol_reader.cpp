#include "archive/symbol_reader.h"

namespace fb {
namespace {

std::uint32_t read_frequency(ByteReader& in) {
  const std::uint32_t low = in.number<std::uint8_t>("a frequency");
  if (low < 0x80) return low;
  const std::uint32_t high = in.number<std::uint8_t>("a frequency");
  return (low & 0x7f) | high << 7;
}

}  // namespace

SymbolReader::SymbolReader(ByteReader& in, std::size_t contexts) : in_(&in) {
  in.budget().take(contexts * symbol_slots, sizeof(std::uint32_t), "symbol tables");
  slots_.resize(contexts * symbol_slots);
  for (std::size_t context = 0; context < contexts; ++context) {
    std::uint32_t* const slots = &slots_[context * symbol_slots];
    const auto count = in.number<std::uint16_t>("a number of frequencies");
    if (count == 0) {  // always 0, at no cost
      for (std::uint32_t slot = 0; slot < symbol_slots; ++slot) slots[slot] = (symbol_slots - 1) << 20 | slot << 8;
      continue;
    }
    const std::uint32_t first = in.number<std::uint8_t>("a symbol");
    if (first + count > 256) in.damaged("a symbol does not fit a byte");
    std::uint32_t slot = 0;
    for (std::uint32_t symbol = first; symbol < first + count; ++symbol) {
      const std::uint32_t frequency = read_frequency(in);
      if (frequency > symbol_slots - slot) in.damaged("the frequencies of symbols are too large");
      for (std::uint32_t i = 0; i < frequency; ++i) slots[slot++] = (frequency - 1) << 20 | i << 8 | symbol;
    }
    if (slot != symbol_slots) in.damaged("the frequencies of symbols are too small");
  }
  begin_.slots_ = slots_.data();
  for (std::uint32_t& state : begin_.states_) {
    state = in.number<std::uint32_t>("a coder's state");
    if (state < least_state) in.damaged("a coder's state is too small");
  }
  const auto words = in.take(in.left(), "coded symbols");
  begin_.at_ = words.data();
  begin_.end_ = words.data() + words.size();
}

void SymbolReader::end(const SymbolCursor& cursor) const {
  if (cursor.exhausted_) in_->damaged("there are too few coded symbols");
  if (cursor.at_ != cursor.end_) in_->damaged("there are too many coded symbols");
  for (const std::uint32_t state : cursor.states_)
    if (state != least_state) in_->damaged("the coded symbols do not end as they should");
}

}  // namespace fb
