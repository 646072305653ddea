// Entropy decoding: small numbers, each coded by how often it occurs in its context (range asymmetric numeral systems,
// Jarek Duda, "Asymmetric numeral systems", arXiv 1311.2540; see FORMAT.md, "Coded symbols").
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "archive/byte_reader.h"

namespace fb {

inline constexpr std::uint32_t symbol_bits = 10, symbol_slots = 1u << symbol_bits;  // frequencies of a table sum to
inline constexpr std::uint32_t symbol_lanes = 4;
inline constexpr std::uint32_t least_state = 1u << 16;
inline constexpr std::uint32_t most_tables = 64;  // that the contexts of a section share

// Where decoding is: small, so that a loop may keep it in registers. Every symbol is coded in one of four lanes, which
// do not depend on each other; which one is fixed by what the symbol means. Whether words are left is not asked for
// every symbol, as no branch that depends on them may be there: see exhausted().
class SymbolCursor {
 public:
  // After the words of the section lie so many zeros: who reads no more symbols than that between one question whether
  // the cursor is exhausted and the next reads nothing beyond.
  static constexpr std::size_t spare_words = 128;
  bool exhausted() const { return at_ > end_; }

  // The next number below 256, coded in this context.
  std::uint32_t symbol(std::size_t lane, std::size_t context) {
    std::uint32_t& state = states_[lane];
    const std::size_t table = tables_[context];
    const std::uint32_t slot = state % symbol_slots, symbol = symbols_[table * symbol_slots + slot];
    const std::uint32_t share = shares_[256 * table + symbol];
    state = (share >> 16) * (state >> symbol_bits) + slot - share % 65536;
    refill(state);
    return symbol;
  }

  // The next number of so many bits (at most 12), all values of which are as likely.
  std::uint32_t bits(std::size_t lane, std::uint32_t count) {
    std::uint32_t& state = states_[lane];
    const std::uint32_t value = state & ((1u << count) - 1);
    state >>= count;
    refill(state);
    return value;
  }

 private:
  friend class SymbolReader;

  // Whether a state needs a word is as good as random, so that nothing here is a branch.
  void refill(std::uint32_t& state) {
    const bool needs = state < least_state;
    const std::uint32_t filled = state << 16 | *at_;
    state = needs ? filled : state;
    at_ += needs;
  }

  // Of each context, its table; of each table and slot, the symbol; of each table and symbol, the first slot plus 65536
  // times the frequency. So much smaller than all of it for each slot that most of it stays in the first cache.
  const std::uint8_t *tables_ = nullptr, *symbols_ = nullptr;
  const std::uint32_t* shares_ = nullptr;
  std::array<std::uint32_t, symbol_lanes> states_{};
  const std::uint16_t *at_ = nullptr, *end_ = nullptr;
};

class SymbolReader {
 public:
  // Reads what is left of the section. `in` must outlive this object, which must outlive its cursor.
  SymbolReader(ByteReader& in, std::size_t contexts);

  SymbolCursor begin() const { return begin_; }
  // Fails unless everything was read and nothing more was asked for.
  void end(const SymbolCursor& cursor) const;
  // Fails because of what was read: for want of symbols if they had run out.
  [[noreturn]] void refuse(const SymbolCursor& cursor, const char* what) const;

 private:
  const ByteReader* in_;
  std::vector<std::uint8_t> tables_, symbols_;
  std::vector<std::uint32_t> shares_;
  std::vector<std::uint16_t> words_;
  SymbolCursor begin_;
};

}  // namespace fb
