// Entropy decoding by range asymmetric numeral systems (rANS): symbols below 256, each coded by one of several tables
// of frequencies, and raw bits, in interleaved streams. Jarek Duda, "Asymmetric numeral systems", arXiv 1311.2540;
// FORMAT.md, "Coded symbols".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "archive/container/byte_reader.h"

namespace fb::archive {

inline constexpr std::uint32_t table_bits = 10, table_slots = 1u << table_bits;  // a table's frequencies sum to this
inline constexpr std::uint32_t stream_count = 4;                                 // of a part
inline constexpr std::uint32_t min_state = 1u << 16;  // a state below is renormalised by a 16-bit word

// A frequency table. Symbol and frequency are looked up one after the other, because a table of both per slot would be
// four times as large and exceed the first-level cache.
struct FrequencyTable {
  const std::uint8_t* symbol_of_slot;     // of table_slots
  const std::uint32_t* frequency_starts;  // of 256 symbols: frequency << 16 | first slot of the symbol
};

// The frequency tables of a section.
struct FrequencyTables {
  std::pmr::vector<std::uint8_t> symbol_of_slot;     // tables x table_slots
  std::pmr::vector<std::uint32_t> frequency_starts;  // tables x 256

  FrequencyTable operator[](std::size_t table) const {
    return {&symbol_of_slot[table * table_slots], &frequency_starts[table * 256]};
  }
};

// The decoder of one interleaved stream. Streams share nothing but the tables, so that their decoding overlaps in the
// processor. Which part and stream hold a symbol follows from its meaning.
//
// Decoding does not check for the end of the words, because a data-dependent branch per symbol would be slow. Instead
// the words are followed by padding: call exhausted() at least once per `padding_words` symbols or raw bits.
class RansStream {
 public:
  static constexpr std::size_t padding_words = 128;
  bool exhausted() const { return word_ > end_; }

  // The next symbol, below 256, coded by this table.
  std::uint32_t symbol(FrequencyTable table) {
    const std::uint32_t slot = state_ % table_slots, symbol = table.symbol_of_slot[slot];
    const std::uint32_t entry = table.frequency_starts[symbol];
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
  struct TableLimits {
    std::size_t fewest, most;
  };
  // Reads tables, states and words to the end of the section. Fails if the number of tables is beyond its limits. `in`
  // must outlive this object, which must outlive its streams.
  RansReader(ByteReader& in, TableLimits limits, std::size_t parts);

  const FrequencyTables& tables() const { return tables_; }
  std::size_t table_count() const { return tables_.frequency_starts.size() / 256; }
  // The streams of a part at their beginning.
  const RansStreams& streams(std::size_t part) const { return parts_[part]; }
  // Fails unless each stream of a part, advanced by decoding, has used up its words and is in the final state.
  void end(const RansStreams& streams) const;
  // Fails because of a symbol decoded from this stream, or one of these: with `what`, or because it is exhausted.
  [[noreturn]] void corrupt(const RansStream& stream, const char* what) const;
  [[noreturn]] void corrupt(const RansStreams& streams, const char* what) const;

 private:
  const ByteReader* in_;
  FrequencyTables tables_;
  std::pmr::vector<std::uint16_t> words_;
  std::vector<RansStreams> parts_;
};

}  // namespace fb::archive
