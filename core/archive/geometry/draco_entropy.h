// Entropy coding of Draco data, as DRACO.md describes it: plain bits, and bits and symbols by range asymmetric numeral
// systems (rANS) whose bytes are read from back to front. Input is untrusted: everything fails with `corrupt`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "archive/container/byte_reader.h"

namespace fb::archive {

// A number of up to 32 bits, seven in each byte, the lowest first.
std::uint32_t read_draco_varint(ByteReader& in);

// Bits, the lowest of each byte first.
class DracoBits {
 public:
  // `in` is for messages; it and `bytes` must outlive this object.
  DracoBits(const ByteReader& in, std::span<const std::byte> bytes) : in_(in), bytes_(bytes) {}

  std::uint32_t take(std::uint32_t count);  // at most 32
  // The number of bytes used. Fails unless the other bits of the last one are 0.
  std::size_t end() const;

 private:
  const ByteReader& in_;
  std::span<const std::byte> bytes_;
  std::uint64_t at_ = 0;
};

// The state of a rANS decoder.
class DracoRans {
 public:
  // Fails unless the state is the initial one of the encoder and all bytes were used.
  void end();

 protected:
  // `base`: the least state after renormalisation. `in` is for messages and must outlive this object.
  DracoRans(const ByteReader& in, std::span<const std::byte> bytes, std::uint32_t base);
  void renormalise();

  std::uint32_t state_ = 0;

 private:
  const ByteReader& in_;
  std::span<const std::byte> bytes_;
  std::uint32_t base_;
};

// Bits of which a share, in 256ths, is 0.
class DracoRansBits : public DracoRans {
 public:
  explicit DracoRansBits(ByteReader& in) : DracoRansBits(in, in.number<std::uint8_t>("Draco's share of zeros")) {}
  bool bit();

 private:
  DracoRansBits(ByteReader& in, std::uint32_t zeros);
  std::uint32_t zeros_;
};

// The frequencies of symbols, which sum to 2^precision.
struct DracoFrequencies {
  struct Symbol {
    std::uint32_t frequency = 0, start = 0;
  };
  std::uint32_t precision = 0;  // at most 20
  std::pmr::vector<Symbol> symbols;
  std::pmr::vector<std::uint32_t> symbol_of_slot;

  // Of at most `limit` symbols.
  DracoFrequencies(ByteReader& in, std::uint32_t precision, std::uint32_t limit);
};

class DracoSymbols : public DracoRans {
 public:
  // Reads frequencies, then the bytes.
  DracoSymbols(ByteReader& in, std::uint32_t precision, std::uint32_t limit)
      : DracoSymbols(in, DracoFrequencies(in, precision, limit)) {}
  std::uint32_t symbol();

 private:
  DracoSymbols(ByteReader& in, DracoFrequencies frequencies);
  DracoFrequencies frequencies_;
};

}  // namespace fb::archive
