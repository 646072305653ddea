// Entropy coding, the counterpart of symbol_reader.h. Symbols are collected first and coded by how often they came.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "archive/container/byte_writer.h"

namespace fb::archive {

class SymbolWriter {
 public:
  explicit SymbolWriter(std::size_t contexts) : contexts_(contexts) {}

  // The stream of what follows, 0 at first; see SymbolStream.
  void select_stream(std::size_t stream) { lane_ = static_cast<std::uint8_t>(stream); }
  // A number below 256 in a context.
  void symbol(std::size_t context, std::uint32_t value) {
    steps_.push_back({static_cast<std::uint16_t>(context), lane_, 0, static_cast<std::uint16_t>(value)});
  }
  // A number of `count` bits, at most 12.
  void bits(std::uint32_t count, std::uint32_t value) {
    steps_.push_back({0, lane_, static_cast<std::uint8_t>(count), static_cast<std::uint16_t>(value)});
  }
  // Appends tables and coded symbols.
  void write(ByteWriter& out) const;

 private:
  struct Step {
    std::uint16_t context;
    std::uint8_t stream, plain_bits;  // 0: coded in the context
    std::uint16_t value;
  };
  std::size_t contexts_;
  std::uint8_t lane_ = 0;
  std::vector<Step> steps_;
};

}  // namespace fb::archive
