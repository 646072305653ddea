// Entropy coding, the counterpart of rans_reader.h. Symbols are collected first and coded by their frequencies at the
// end.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "archive/coding/rans_reader.h"
#include "archive/container/byte_writer.h"

namespace fb::archive {

using SymbolCounts = std::array<std::uint32_t, 256>;  // occurrences of each symbol

class RansWriter {
 public:
  // At most 255 tables.
  explicit RansWriter(std::size_t tables, std::size_t parts = 1) : tables_(tables), parts_(parts) {}

  // The part and the stream of the symbols and bits that follow; 0 and 0 at first.
  void select(std::size_t part, std::size_t stream) {
    stream_ = static_cast<std::uint8_t>(part * stream_count + stream);
  }
  // A symbol below 256, coded by a table.
  void symbol(std::size_t table, std::uint32_t value) {
    operations_.push_back({static_cast<std::uint8_t>(table), stream_, 0, static_cast<std::uint16_t>(value)});
  }
  // `count` raw bits, at most 12.
  void bits(std::uint32_t count, std::uint32_t value) {
    operations_.push_back({0, stream_, static_cast<std::uint8_t>(count), static_cast<std::uint16_t>(value)});
  }
  // Appends tables, states and words.
  void write(ByteWriter& out) const;

 private:
  struct Operation {
    std::uint8_t table, stream, raw_bits;  // stream: counted through all parts; raw_bits 0: a symbol
    std::uint16_t value;
  };

  std::vector<SymbolCounts> count_symbols() const;  // per table

  std::size_t tables_, parts_;
  std::uint8_t stream_ = 0;
  std::vector<Operation> operations_;
};

}  // namespace fb::archive
