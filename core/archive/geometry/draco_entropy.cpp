#include "archive/geometry/draco_entropy.h"

#include <algorithm>

namespace fb::archive {
namespace {

constexpr std::uint32_t bit_base = 4096;  // the least state of a decoder of bits

}  // namespace

std::uint32_t read_draco_varint(ByteReader& in) {
  std::uint64_t value = 0;
  for (unsigned place = 0; place < 5; ++place) {
    const auto byte = in.number<std::uint8_t>("a number of the Draco data");
    value |= std::uint64_t(byte & 127u) << 7 * place;
    if (byte >= 128) continue;
    if (value > UINT32_MAX) break;
    return static_cast<std::uint32_t>(value);
  }
  in.corrupt("a number of the Draco data is too large");
}

std::uint32_t DracoBits::take(std::uint32_t count) {
  if (count > 8 * std::uint64_t(bytes_.size()) - at_) in_.corrupt("the Draco data has too few bits");
  std::uint64_t value = 0;
  for (std::uint32_t done = 0; done < count;) {
    const auto offset = static_cast<std::uint32_t>(at_ % 8), here = std::min(8 - offset, count - done);
    const auto byte = std::to_integer<std::uint32_t>(bytes_[static_cast<std::size_t>(at_ / 8)]);
    value |= std::uint64_t(byte >> offset & ((1u << here) - 1)) << done;
    done += here;
    at_ += here;
  }
  return static_cast<std::uint32_t>(value);
}

std::size_t DracoBits::end() const {
  const auto used = static_cast<std::size_t>((at_ + 7) / 8);
  if (at_ % 8 != 0 && std::to_integer<unsigned>(bytes_[used - 1]) >> at_ % 8 != 0)
    in_.corrupt("bits of the Draco data that mean nothing");
  return used;
}

DracoRans::DracoRans(const ByteReader& in, std::span<const std::byte> bytes, std::uint32_t base)
    : in_(in), bytes_(bytes), base_(base) {
  if (bytes.empty()) in.corrupt("the Draco data has an empty rANS stream");
  const std::size_t size = (std::to_integer<std::size_t>(bytes.back()) >> 6) + 1;
  if (size > bytes.size()) in.corrupt("a rANS stream of the Draco data is shorter than its state");
  for (std::size_t i = 0; i < size; ++i)
    state_ |= std::to_integer<std::uint32_t>(bytes[bytes.size() - size + i]) << 8 * i;
  state_ &= (1u << (8 * size - 2)) - 1;
  state_ += base;
  if (state_ >= 256 * base) in.corrupt("the state of a rANS stream of the Draco data is too large");
  bytes_ = bytes.first(bytes.size() - size);
}

void DracoRans::renormalise() {
  while (state_ < base_) {
    if (bytes_.empty()) in_.corrupt("a rANS stream of the Draco data is too short");
    state_ = state_ << 8 | std::to_integer<std::uint32_t>(bytes_.back());
    bytes_ = bytes_.first(bytes_.size() - 1);
  }
}

void DracoRans::end() {
  renormalise();
  if (!bytes_.empty() || state_ != base_) in_.corrupt("a rANS stream of the Draco data does not end as it should");
}

DracoRansBits::DracoRansBits(ByteReader& in, std::uint32_t zeros)
    : DracoRans(in, in.take(read_draco_varint(in), "Draco's bits"), bit_base), zeros_(zeros) {}

bool DracoRansBits::bit() {
  renormalise();
  const std::uint32_t high = state_ >> 8, low = state_ & 255, ones = 256 - zeros_;
  const bool one = low < ones;
  state_ = one ? high * ones + low : high * zeros_ + low - ones;
  return one;
}

DracoFrequencies::DracoFrequencies(ByteReader& in, std::uint32_t bits, std::uint32_t limit)
    : precision(bits), symbols(&in.budget()), symbol_of_slot(&in.budget()) {
  const char* const wrong = "the frequencies of Draco's symbols";
  const std::uint32_t count = read_draco_varint(in), slots = 1u << precision;
  if (count == 0 || count > limit) in.corrupt("the number of Draco's symbols");
  symbols.resize(count);
  symbol_of_slot.resize(slots);
  std::uint32_t start = 0;
  for (std::uint32_t symbol = 0; symbol < count;) {
    const auto byte = in.number<std::uint8_t>(wrong);
    if ((byte & 3) == 3) {
      symbol += (byte >> 2) + 1u;
      if (symbol > count) in.corrupt(wrong);
      continue;
    }
    std::uint32_t frequency = byte >> 2;
    for (unsigned place = 0; place < (byte & 3u); ++place)
      frequency |= std::uint32_t(in.number<std::uint8_t>(wrong)) << (8 * place + 6);
    if (frequency > slots - start) in.corrupt(wrong);
    symbols[symbol] = {frequency, start};
    std::fill_n(symbol_of_slot.begin() + start, frequency, symbol);
    start += frequency;
    ++symbol;
  }
  if (start != slots) in.corrupt(wrong);
}

DracoSymbols::DracoSymbols(ByteReader& in, DracoFrequencies frequencies)
    : DracoRans(in, in.take(read_draco_varint(in), "Draco's symbols"), 4u << frequencies.precision),
      frequencies_(std::move(frequencies)) {}

std::uint32_t DracoSymbols::symbol() {
  renormalise();
  const std::uint32_t slot = state_ & ((1u << frequencies_.precision) - 1);
  const std::uint32_t symbol = frequencies_.symbol_of_slot[slot];
  const DracoFrequencies::Symbol entry = frequencies_.symbols[symbol];
  state_ = entry.frequency * (state_ >> frequencies_.precision) + slot - entry.start;
  return symbol;
}

}  // namespace fb::archive
