// Entropy decoding: small numbers, each coded by how often it occurs in its context (range asymmetric numeral systems,
// Jarek Duda, "Asymmetric numeral systems", arXiv 1311.2540; see FORMAT.md, "Coded symbols").
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "archive/container/byte_reader.h"

namespace fb::archive {

inline constexpr std::uint32_t symbol_bits = 10, symbol_slots = 1u << symbol_bits;  // frequencies of a table sum to
inline constexpr std::uint32_t symbol_streams = 4;
inline constexpr std::uint32_t least_state = 1u << 16;
inline constexpr std::uint32_t most_tables = 64;  // that the contexts of a section share

// The tables of frequencies that the contexts of a section share: of each context, its table; of each table and slot,
// the symbol; of each table and symbol, the first slot plus 65536 times the frequency. So much smaller than all of it
// for each slot that most of it stays in the first cache.
struct SymbolTables {
  std::vector<std::uint8_t> of_context, symbols;
  std::vector<std::uint32_t> shares;
};

// Where decoding is in one stream. Every symbol is coded in one of a few streams, which have nothing in common but the
// tables: who goes on in all of them at a time does not wait for one. Which stream is fixed by what the symbol means.
// Whether words are left is not asked for every symbol, as no branch that depends on them may be there: see
// exhausted().
class SymbolStream {
 public:
  // After the words of the section lie so many zeros: who reads no more symbols than that between one question whether
  // the stream is exhausted and the next reads nothing beyond.
  static constexpr std::size_t spare_words = 128;
  bool exhausted() const { return at_ > end_; }

  // The next number below 256, coded in this context.
  std::uint32_t symbol(const SymbolTables& tables, std::size_t context) {
    return symbol_of(tables, tables.of_context[context]);
  }
  // The same, where the context's table is known.
  std::uint32_t symbol_of(const SymbolTables& tables, std::size_t table) {
    const std::uint32_t slot = state_ % symbol_slots, symbol = tables.symbols[table * symbol_slots + slot];
    const std::uint32_t share = tables.shares[256 * table + symbol];
    state_ = (share >> 16) * (state_ >> symbol_bits) + slot - share % 65536;
    refill();
    return symbol;
  }

  // The next number of so many bits (at most 12), all values of which are as likely.
  std::uint32_t bits(std::uint32_t count) {
    const std::uint32_t value = state_ & ((1u << count) - 1);
    state_ >>= count;
    refill();
    return value;
  }

 private:
  friend class SymbolReader;

  // Whether a state needs a word is as good as random, so that nothing here is, or may become, a branch.
  void refill() {
    const std::uint32_t needs = state_ < least_state;
    state_ = state_ << (16 * needs) | (*at_ & (0 - needs));
    at_ += needs;
  }

  std::uint32_t state_ = 0;
  const std::uint16_t *at_ = nullptr, *end_ = nullptr;
};

using SymbolStreams = std::array<SymbolStream, symbol_streams>;

class SymbolReader {
 public:
  // Reads what is left of the section. `in` must outlive this object, which must outlive its streams.
  SymbolReader(ByteReader& in, std::size_t contexts);

  const SymbolTables& tables() const { return tables_; }
  SymbolStreams begin() const { return begin_; }
  // Fails unless everything was read and nothing more was asked for.
  void end(const SymbolStreams& streams) const;
  // Fails because of what was read in a stream: for want of symbols if they had run out.
  [[noreturn]] void refuse(const SymbolStream& stream, const char* what) const;

 private:
  const ByteReader* in_;
  SymbolTables tables_;
  std::vector<std::uint16_t> words_;
  SymbolStreams begin_;
};

}  // namespace fb::archive
