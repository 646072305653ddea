// Entropy decoding: small numbers, each coded by how often it occurs in its context (range asymmetric numeral systems,
// Jarek Duda, "Asymmetric numeral systems", arXiv 1311.2540; see FORMAT.md, "Coded symbols").
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "archive/byte_reader.h"

namespace fb {

inline constexpr std::uint32_t symbol_bits = 10, symbol_slots = 1u << symbol_bits;  // frequencies of a context sum to
inline constexpr std::uint32_t symbol_lanes = 4;
inline constexpr std::uint32_t least_state = 1u << 16;

// Where decoding is: small, so that a loop may keep it in registers. Every symbol is coded in one of four lanes, which
// do not depend on each other; which one is fixed by what the symbol means.
class SymbolCursor {
 public:
  // The next number below 256, coded in this context.
  std::uint32_t symbol(std::size_t lane, std::size_t context) {
    std::uint32_t& state = states_[lane];
    const std::uint32_t entry = slots_[context * symbol_slots + state % symbol_slots];
    state = ((entry >> 20) + 1) * (state >> symbol_bits) + (entry >> 8) % symbol_slots;
    refill(state);
    return entry & 0xff;
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

  void refill(std::uint32_t& state) {
    if (state >= least_state) return;
    if (end_ - at_ < 2) {
      exhausted_ = true;
      state = least_state;  // anything valid: the section will be refused
      return;
    }
    state = state << 16 | std::uint32_t(at_[0]) | std::uint32_t(at_[1]) << 8;
    at_ += 2;
  }

  // For each context and slot: frequency - 1 in bits 20 to 31, slot - first slot of the symbol in bits 8 to 19, the
  // symbol in bits 0 to 7.
  const std::uint32_t* slots_ = nullptr;
  std::array<std::uint32_t, symbol_lanes> states_{};
  const std::byte *at_ = nullptr, *end_ = nullptr;
  bool exhausted_ = false;
};

class SymbolReader {
 public:
  // Reads the frequencies of all contexts and takes what is left of the section. `in` must outlive this object, which
  // must outlive its cursor.
  SymbolReader(ByteReader& in, std::size_t contexts);

  SymbolCursor begin() const { return begin_; }
  // Fails unless everything was read and nothing more was asked for.
  void end(const SymbolCursor& cursor) const;

 private:
  const ByteReader* in_;
  std::vector<std::uint32_t> slots_;
  SymbolCursor begin_;
};

}  // namespace fb
