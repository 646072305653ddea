// Entropy decoding by range asymmetric numeral systems (rANS): symbols below 256, each coded in a context, and raw
// bits, in interleaved streams. Jarek Duda, "Asymmetric numeral systems", arXiv 1311.2540; FORMAT.md, "Coded symbols".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "archive/container/byte_reader.h"

namespace fb::archive {

inline constexpr std::uint32_t table_bits = 10, table_slots = 1u << table_bits;  // a table's frequencies sum to this
inline constexpr std::uint32_t stream_count = 4;
inline constexpr std::uint32_t min_state = 1u << 16;  // a state below is renormalised by a 16-bit word
inline constexpr std::uint32_t max_tables = 64;       // that the contexts of a section share

// Frequency tables, shared by contexts. Symbol and frequency are looked up one after the other, because a table of both
// per slot would be four times as large and exceed the first-level cache.
struct FrequencyTables {
  std::pmr::vector<std::uint8_t> table_of_context;   // contexts
  std::pmr::vector<std::uint8_t> symbol_of_slot;     // tables x table_slots
  std::pmr::vector<std::uint32_t> frequency_starts;  // tables x 256: frequency << 16 | first slot of the symbol
};

// The decoder of one interleaved stream. Streams share nothing but the tables, so that their decoding overlaps in the
// processor. Which stream holds a symbol follows from its meaning.
//
// Decoding does not check for the end of the words, because a data-dependent branch per symbol would be slow. Instead
// the words are followed by padding: call exhausted() at least once per `padding_words` symbols or raw bits.
class RansStream {
 public:
  static constexpr std::size_t padding_words = 128;
  bool exhausted() const { return word_ > end_; }

  // The next symbol, below 256, coded in this context.
  std::uint32_t symbol(const FrequencyTables& tables, std::size_t context) {
    return symbol_of_table(tables, tables.table_of_context[context]);
  }
  // The same, if the context's table is known.
  std::uint32_t symbol_of_table(const FrequencyTables& tables, std::size_t table) {
    const std::uint32_t slot = state_ % table_slots, symbol = tables.symbol_of_slot[table * table_slots + slot];
    const std::uint32_t entry = tables.frequency_starts[256 * table + symbol];
    state_ = (entry >> 16) * (state_ >> table_bits) + slot - entry % 65536;
    renormalise();
    return symbol;
  }

  // The next `count` raw bits, at most 12.
  std::uint32_t bits(std::uint32_t count) {
    const std::uint32_t value = state_ & ((1u << count) - 1);
    state_ >>= count;
    renormalise();
    return value;
  }

 private:
  friend class RansReader;

  // Branch-free: whether the state needs a word is unpredictable.
  void renormalise() {
    const std::uint32_t needs = state_ < min_state;
    state_ = state_ << (16 * needs) | (*word_ & (0 - needs));
    word_ += needs;
  }

  std::uint32_t state_ = 0;
  const std::uint16_t *word_ = nullptr, *end_ = nullptr;
};

using RansStreams = std::array<RansStream, stream_count>;

class RansReader {
 public:
  // Reads tables, states and words to the end of the section. `in` must outlive this object, which must outlive its
  // streams.
  RansReader(ByteReader& in, std::size_t contexts);

  const FrequencyTables& tables() const { return tables_; }
  // The streams at their beginning.
  const RansStreams& streams() const { return streams_; }
  // Fails unless each stream, advanced by decoding, has used up its words and is in the final state.
  void end(const RansStreams& streams) const;
  // Fails because of a symbol decoded from this stream: with `what`, or because the stream is exhausted.
  [[noreturn]] void corrupt(const RansStream& stream, const char* what) const;

 private:
  const ByteReader* in_;
  FrequencyTables tables_;
  std::pmr::vector<std::uint16_t> words_;
  RansStreams streams_;
};

}  // namespace fb::archive
